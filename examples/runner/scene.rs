//! The runner on a stage.

use crate::{
    cape::Cape,
    figure::{self, Bodies},
    gait::{EVEN, Gait, Joint, PERIOD, SPEED as WALK},
    run::{self, Runner},
};
use bevy::{
    animation::{AnimatedBy, AnimationTargetId, animated_field},
    prelude::*,
};
use bevy_cloth::{physics::Fabric, prelude::*};
use example_common::{
    clock::SceneReset,
    orbit_camera::OrbitCamera,
    scene::{SceneCamera, SceneState},
    stage::Stage,
};

const COLOUR: [f32; 3] = [0.60, 0.07, 0.11];
/// Samples of two steps.
const SAMPLES: u16 = 24;

/// Every part of the figure has a collider of its own.
const BODIES: Bodies = Bodies {
    engine: |_| {},
    figure: |_| {},
    part: |part, capsule| {
        part.insert(ClothCollider::from(capsule));
    },
};

pub struct RunnerPlugin {
    pub fabric: Fabric,
    /// Cells of the cape from side to side.
    pub columns: usize,
}

impl Plugin for RunnerPlugin {
    fn build(&self, app: &mut App) {
        let (fabric, columns) = (self.fabric, self.columns);
        (BODIES.engine)(app);
        app.add_systems(Startup, move |world: &mut World| build(world, fabric, columns))
            // Once a frame, whatever the frame rate: as most games move their characters.
            .add_systems(Update, run)
            .add_observer(restart);
    }
}

fn build(world: &mut World, fabric: Fabric, columns: usize) {
    let camera = OrbitCamera { focus: Vec3::new(0.0, 0.85, 0.0), distance: 4.2, yaw: 0.5, pitch: 0.2 };
    let stage = Stage { floor: Vec3::ZERO, radius: 2.4, yaw: camera.yaw };
    let camera = world.spawn(camera).id();
    world.insert_resource(SceneCamera(camera));
    stage.build(world, camera);
    world.spawn(ClothCollider::half_space(Dir3::Y));
    let figure = figure::build(world, 0.0, BODIES);
    let runner = Runner::default();
    world.entity_mut(figure).insert((runner.place(), runner));
    animate(world, figure);
    Cape { fabric, colour: COLOUR, columns }.hang(world, figure);
}

/// Plays two steps of the gait over and over, as fast as it runs.
fn animate(world: &mut World, figure: Entity) {
    let mut joints = world.query::<(Entity, &Joint)>();
    let joints: Vec<_> = joints.iter(world).map(|(entity, joint)| (entity, *joint)).collect();
    let mut clip = AnimationClip::default();
    for (entity, joint) in joints {
        let target = AnimationTargetId::from_name(&Name::new(format!("{joint:?}")));
        let samples = (0..=SAMPLES).map(|k| {
            let time = PERIOD * f32::from(k) / f32::from(SAMPLES);
            (time, Quat::from_rotation_x(-Gait::at(EVEN + time, 0.0).bend(joint)))
        });
        let curve = UnevenSampleAutoCurve::new(samples).expect("samples are in order");
        clip.add_curve_to_target(target, AnimatableCurve::new(animated_field!(Transform::rotation), curve));
        world.entity_mut(entity).insert((target, AnimatedBy(figure)));
    }
    let clip = world.resource_mut::<Assets<AnimationClip>>().add(clip);
    let (graph, steps) = AnimationGraph::from_clip(clip);
    let graph = world.resource_mut::<Assets<AnimationGraph>>().add(graph);
    let mut player = AnimationPlayer::default();
    // Longer steps than those of a walk, and more of them.
    player.play(steps).repeat().set_speed((run::SPEED / WALK).sqrt());
    world.entity_mut(figure).insert((AnimationGraphHandle(graph), player));
}

fn run(time: Res<Time>, state: Res<SceneState>, mut runners: Query<(&mut Runner, &mut Transform)>) {
    if *state == SceneState::Ready {
        for (mut runner, mut transform) in &mut runners {
            runner.0 += time.delta_secs();
            *transform = runner.place();
        }
    }
}

fn restart(_: On<SceneReset>, mut runners: Query<(&mut Runner, &mut Transform)>) {
    for (mut runner, mut transform) in &mut runners {
        *runner = Runner::default();
        *transform = runner.place();
    }
}
