//! Jumps of what holds cloth or touches it: found by snap turns, dashes, pauses and floating origins that whipped cloth at up to 180 m/s.

use std::f32::consts::PI;

use bevy::prelude::*;
use bevy_cloth::plugin::*;

use crate::common::*;
use crate::stage::*;

/// Nothing may be stretched further or be faster against its wearer, m/s.
const STRETCH: f64 = 0.1;
const SPEED: f64 = 5.0;

impl Worst {
    #[track_caller]
    fn assert_calm(self, case: &str) {
        assert!(self.stretch <= STRETCH && self.speed <= SPEED, "{case}: {self:?}");
    }
}

fn rates() -> impl Iterator<Item = (f64, f64)> {
    [(64.0, 30.0), (64.0, 60.0), (60.0, 60.0), (64.0, 144.0)].into_iter()
}

fn edit(app: &mut App, entity: Entity, change: impl FnOnce(&mut Transform)) {
    change(&mut app.world_mut().get_mut::<Transform>(entity).expect("a transform"));
}

/// A cape that hangs 25 cm behind the axis of its wearer.
fn hung(app: &mut App) -> (Entity, Entity) {
    let wearer = app.world_mut().spawn(Transform::from_xyz(0.0, 1.0, 0.0)).id();
    let cloth = spawn(app, cape(10, 0.25), (collar(), ChildOf(wearer)));
    for _ in 0..60 {
        frame(app, 1.0 / 60.0);
    }
    (wearer, cloth)
}

fn watch(app: &mut App, cloth: Entity, fps: f64, seconds: f64) -> Worst {
    let mut worst = Worst::default();
    for _ in 0..(seconds * fps) as usize {
        frame(app, 1.0 / fps);
        worst.look(app, cloth, Vec3::ZERO);
    }
    worst
}

#[test]
fn facing_about_and_steps_within_a_frame_do_not_whip_the_cape() {
    let turn = |angle: f32| Transform::from_rotation(Quat::from_rotation_y(angle));
    let steps = [0.3, 1.0, 1.9, 2.1, 50.0].map(|x| Transform::from_xyz(x, 0.0, 0.0));
    let turns = [PI / 6.0, PI / 2.0, 0.75 * PI, PI].map(turn);
    for (hz, fps) in rates() {
        for change in steps.iter().chain(&turns) {
            let mut app = app_at(hz, Mover::Update);
            let (wearer, cloth) = hung(&mut app);
            edit(&mut app, wearer, |at| *at = at.mul_transform(*change));
            watch(&mut app, cloth, fps, 1.0).assert_calm(&format!("{hz} Hz, {fps}: {change:?}"));
        }
    }
}

/// Found where the cape was carried right and its pins then went the way that they had come.
#[test]
fn facing_about_on_the_run_does_not_whip_the_cape() {
    for (hz, fps) in rates() {
        for mover in [Mover::FixedUpdate, Mover::Update] {
            for back in [1.0, -1.0] {
                let mut app = app_at(hz, mover);
                let wearer = app.world_mut().spawn(Transform::from_xyz(0.0, 1.0, 0.0)).id();
                let cloth = spawn(&mut app, cape(10, 0.25), (collar(), ChildOf(wearer)));
                #[derive(Resource)]
                struct Run(f32);
                let run = |time: Res<Time>, run: Res<Run>, mut at: Query<&mut Transform, Without<ClothMesh>>| {
                    at.single_mut().unwrap().translation.z -= run.0 * time.delta_secs();
                };
                app.insert_resource(Run(0.0));
                match mover {
                    Mover::FixedUpdate => app.add_systems(FixedUpdate, run.before(ClothSystems::Collect)),
                    _ => app.add_systems(Update, run),
                };
                for i in 0..(2.0 * fps) as usize {
                    app.world_mut().resource_mut::<Run>().0 = (12.0 * i as f32 / fps as f32).min(6.0);
                    frame(&mut app, 1.0 / fps);
                }
                edit(&mut app, wearer, |at| at.rotate_y(PI));
                app.world_mut().resource_mut::<Run>().0 *= back;
                let mut worst = Worst::default();
                for _ in 0..(0.5 * fps) as usize {
                    frame(&mut app, 1.0 / fps);
                    worst.look(&app, cloth, Vec3::ZERO);
                }
                worst.speed -= 6.0;
                worst.assert_calm(&format!("{hz} Hz, {fps}, {mover:?}, {back}"));
            }
        }
    }
}

#[test]
fn a_dash_does_not_whip_the_cape() {
    for (hz, fps) in rates() {
        for way in [0.2, 0.5, 1.9, 2.1] {
            let mut app = app_at(hz, Mover::Update);
            let (wearer, cloth) = hung(&mut app);
            // So far in 1/60 s, for a sixth of a second.
            let mut worst = Worst::default();
            for _ in 0..(fps / 6.0) as usize {
                edit(&mut app, wearer, |at| at.translation.x += way * 60.0 / fps as f32);
                frame(&mut app, 1.0 / fps);
                worst.look(&app, cloth, Vec3::ZERO);
            }
            // The wearer has a speed of its own meanwhile.
            worst.speed -= f64::from(60.0 * way).min(worst.speed);
            worst.assert_calm(&format!("{hz} Hz, {fps}: during {way}"));
            watch(&mut app, cloth, fps, 1.0).assert_calm(&format!("{hz} Hz, {fps}: after {way}"));
        }
    }
}

#[test]
fn what_moves_while_time_stands_is_carried() {
    for (hz, fps) in rates() {
        for way in [0.05, 0.3, 0.5, 1.0, 50.0] {
            let mut app = app_at(hz, Mover::Update);
            let (wearer, cloth) = hung(&mut app);
            app.world_mut().resource_mut::<Time<Virtual>>().pause();
            for _ in 0..20 {
                edit(&mut app, wearer, |at| at.translation.x += way / 20.0);
                frame(&mut app, 1.0 / fps);
            }
            let shown = local(&app, cloth);
            app.world_mut().resource_mut::<Time<Virtual>>().unpause();
            let worst = watch(&mut app, cloth, fps, 0.5);
            assert!(worst.stretch < 0.02 && worst.speed < 0.2, "{hz} Hz, {fps}: {way}: {worst:?}");
            for (now, before) in local(&app, cloth).iter().zip(shown) {
                assert_near(*now, before, 0.02);
            }
        }
    }
}

#[test]
fn another_parent_carries_the_cape() {
    for (hz, fps) in rates() {
        let mut app = app_at(hz, Mover::Update);
        let (_, cloth) = hung(&mut app);
        for (x, scale) in [(0.4, 1.0), (5.0, 2.0)] {
            let at = Transform::from_xyz(x, 1.0, 2.0).with_rotation(Quat::from_rotation_y(1.0));
            let parent = app.world_mut().spawn(at.with_scale(Vec3::splat(scale))).id();
            app.world_mut().entity_mut(cloth).insert(ChildOf(parent));
            watch(&mut app, cloth, fps, 0.5).assert_calm(&format!("{hz} Hz, {fps}: {x}"));
        }
        app.world_mut().entity_mut(cloth).remove::<ChildOf>();
        watch(&mut app, cloth, fps, 0.5).assert_calm("no parent");
    }
}

#[test]
fn a_floating_origin_moves_everything_and_nothing_notices() {
    for (hz, fps) in rates() {
        for way in [1.5, 3.0, 1e3, 1e5] {
            let mut app = app_at(hz, Mover::Update);
            let floor =
                app.world_mut().spawn((ClothCollider::cuboid(3.0, 0.2, 3.0), Transform::from_xyz(0.0, -0.1, 0.0))).id();
            let sheet = Plane3d::new(Vec3::Y, Vec2::splat(0.4)).mesh().subdivisions(7).build();
            let lying = spawn(&mut app, sheet, Transform::from_xyz(0.0, 0.02, 0.0));
            let (wearer, hanging) = hung(&mut app);
            let far = |app: &App| {
                let at = app.world().get::<Transform>(floor).unwrap().translation;
                state(app, lying).cloth().positions().iter().map(|p| (p.as_vec3() - at).y).fold(f32::MAX, f32::min)
            };
            for entity in [floor, lying, wearer] {
                edit(&mut app, entity, |at| at.translation += Vec3::new(way, 0.3 * way, 0.0));
            }
            let mut worst = Worst::default();
            for _ in 0..fps as usize {
                frame(&mut app, 1.0 / fps);
                worst.look(&app, lying, Vec3::ZERO);
                worst.look(&app, hanging, Vec3::ZERO);
            }
            // At 100 km, f32 has steps of 8 mm.
            let rounding = if way > 1e4 { 20.0 } else { 1.0 };
            assert!(worst.stretch < 0.02 * rounding && worst.speed < 0.3 * rounding, "{hz} {fps} {way}: {worst:?}");
            assert!(far(&app) > 0.05, "{hz} {fps} {way}: it lies on the floor: {}", far(&app));
        }
    }
}

#[test]
fn a_collider_that_rested_is_touched_wherever_it_is_put() {
    for rest in [10, 17, 30, 200] {
        let mut app = app();
        let cloth = spawn(&mut app, cape(10, 0.0), (collar(), Transform::from_xyz(0.0, 1.0, 0.0)));
        let ball = app.world_mut().spawn((ClothCollider::sphere(0.3), Transform::from_xyz(50.0, 0.0, 0.0))).id();
        run(&mut app, rest);
        edit(&mut app, ball, |at| *at = Transform::from_xyz(0.0, 0.5, -0.1));
        run(&mut app, 60);
        assert_eq!(state(&app, cloth).cloth().colliders().len(), 1, "after {rest} ticks at rest");
    }
}

#[test]
fn a_told_teleport_carries_a_step_that_could_be_a_motion() {
    for plugin in [ClothPlugin::default(), ClothPlugin::new(Update)] {
        for told in [true, false] {
            let mut app = app_with(plugin);
            let (wearer, cloth) = hung(&mut app);
            edit(&mut app, wearer, |at| at.translation.x += 0.1);
            if told {
                app.world_mut().trigger(ClothTeleport { entity: wearer });
            }
            let worst = watch(&mut app, cloth, 60.0, 0.3);
            assert_eq!(worst.speed < 0.05, told, "{worst:?}");
        }
    }
}

#[test]
fn a_flag_on_a_vehicle_feels_the_air_at_any_speed_and_rate() {
    for (speed, hz) in [(30.0, 60.0), (60.0, 30.0), (119.0, 60.0), (121.0, 60.0), (40.0, 20.0), (121.0, 20.0)] {
        let mut app = app_at(hz, Mover::FixedUpdate);
        let mut fabric = *ClothMaterial::cotton();
        fabric.air_drag = 2.0;
        let wearer = app.world_mut().spawn(Transform::default()).id();
        let cloth = spawn(&mut app, cape(10, 0.0), (collar(), ClothMaterial(fabric), ChildOf(wearer)));
        app.add_systems(
            FixedUpdate,
            (move |mut at: Query<&mut Transform, Without<ClothMesh>>| {
                at.single_mut().unwrap().translation.z += speed / hz as f32
            })
            .before(ClothSystems::Collect),
        );
        let start = local(&app, cloth)[110];
        let mut streamed: f32 = 0.0;
        for _ in 0..hz as usize {
            frame(&mut app, 1.0 / hz);
            streamed = streamed.max(local(&app, cloth)[110].distance(start));
        }
        assert!(streamed > 0.3, "{speed} m/s at {hz} Hz: its hem moves by {streamed} m");
    }
}

#[test]
fn what_is_held_elsewhere_glides_there() {
    // Let go, fallen by meters, held again; grabbed 0.8 m away.
    let mut app = app();
    let cloth = spawn(&mut app, cape(10, 0.0), (collar(), Transform::from_xyz(0.0, 1.0, 0.0)));
    run(&mut app, 60);
    app.world_mut().entity_mut(cloth).insert(ClothPins::none());
    run(&mut app, 60);
    app.world_mut().entity_mut(cloth).insert(collar());
    run(&mut app, 5);
    let mut worst = Worst::default();
    for _ in 0..120 {
        app.update();
        worst.look(&app, cloth, Vec3::ZERO);
    }
    worst.assert_calm("held again");
    app.world_mut().entity_mut(cloth).insert(ClothPinTargets([(115, Vec3::new(0.0, -0.2, 0.5))].into()));
    let mut worst = Worst::default();
    for _ in 0..120 {
        app.update();
        worst.look(&app, cloth, Vec3::ZERO);
    }
    worst.assert_calm("grabbed");
    assert_near(local(&app, cloth)[115], Vec3::new(0.0, -0.2, 0.5), 1e-5);
}

#[test]
fn a_character_feels_less_and_the_picture_goes_along_all_the_same() {
    let trail = |inertia: ClothInertia| {
        let mut app = app_at(64.0, Mover::Update);
        let (wearer, cloth) = hung(&mut app);
        app.world_mut().entity_mut(cloth).insert(inertia);
        let mut swing: f32 = 0.0;
        for i in 0..60 {
            edit(&mut app, wearer, |at| at.translation.z -= 0.002 * i.min(40) as f32);
            frame(&mut app, 1.0 / 60.0);
            swing = swing.max(local(&app, cloth)[115].distance(Vec3::new(0.0, -0.8, 0.25)));
            assert_near(local(&app, cloth)[0], Vec3::new(-0.4, 0.0, 0.25), 1e-6);
        }
        swing
    };
    let [whole, none] = [ClothInertia::default(), ClothInertia { linear: 0.0, ..default() }].map(trail);
    assert!(whole > 0.3, "{whole}");
    // The air is felt all the same.
    assert!(none < 0.8 * whole, "{none} of {whole}");
}
