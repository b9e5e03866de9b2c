//! An app without a window, as a game has it: the plugin by default, frames of given lengths, things that are moved in one
//! schedule or another. Everything is seen from outside, through what is public.

use core::time::Duration;
use std::sync::Arc;

use bevy::camera::CameraPlugin;
use bevy::camera::primitives::Aabb;
use bevy::ecs::schedule::ScheduleLabel;
use bevy::math::DVec3;
use bevy::mesh::{MeshPlugin, VertexAttributeValues};
use bevy::prelude::*;
use bevy::time::TimeUpdateStrategy;
use bevy_cloth::plugin::{ClothMesh, ClothPins, ClothPlugin, ClothState, ClothSystems};

use super::frames::Frames;

/// Where something is moved.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum When {
    /// Where cloth is stepped, before it.
    FixedUpdate,
    /// Once a frame, before the fixed steps.
    PreUpdate,
    /// Once a frame, after the fixed steps.
    Update,
    /// Once a frame, as animations are: in `PostUpdate`, before transforms are propagated.
    Animation,
}

impl When {
    /// For the reader.
    pub fn name(self) -> &'static str {
        match self {
            Self::FixedUpdate => "FixedUpdate",
            Self::PreUpdate => "PreUpdate",
            Self::Update => "Update",
            Self::Animation => "PostUpdate",
        }
    }
}

/// Writes a transform, or parts of it, by the time of the schedule it is moved in.
pub type Path = Arc<dyn Fn(f64, &mut Transform) + Send + Sync>;

/// Makes a [`Path`].
pub fn path(write: impl Fn(f64, &mut Transform) + Send + Sync + 'static) -> Path {
    Arc::new(write)
}

/// What moves an entity, and where.
#[derive(Component, Clone, Default)]
pub struct Moved(pub Vec<(When, Path)>);

impl Moved {
    /// In one schedule.
    pub fn by(when: When, path: &Path) -> Self {
        Self(vec![(when, path.clone())])
    }
}

/// The worst of all steps since it was last emptied.
#[derive(Resource, Clone, Copy, Debug, Default)]
pub struct Seen {
    /// Speed of the fastest vertex, m/s: infinite if one was not finite.
    pub fastest: f64,
    /// The largest stretch, infinite likewise.
    pub stretch: f64,
}

/// The app.
pub struct Stage {
    app: App,
    lengths: Box<dyn Iterator<Item = Duration>>,
}

impl Stage {
    /// Ticks of so many Hz, and these frames. What is watched begins at `watched` seconds. Starts differ in where the first
    /// frame ends between two ticks: by thirds of a tick.
    pub fn new(hz: f64, frames: Frames, watched: f64, start: u32) -> Self {
        let mut app = App::new();
        app.add_plugins((MinimalPlugins, TransformPlugin, AssetPlugin::default(), MeshPlugin, CameraPlugin))
            .add_plugins(ClothPlugin::default())
            .insert_resource(Time::<Fixed>::from_hz(hz))
            .init_resource::<Seen>()
            .add_systems(FixedUpdate, look.after(ClothSystems::Step));
        moves(&mut app, FixedUpdate, When::FixedUpdate);
        moves(&mut app, PreUpdate, When::PreUpdate);
        moves(&mut app, Update, When::Update);
        moves(&mut app, PostUpdate, When::Animation);
        app.finish();
        app.cleanup();
        let first = Duration::from_secs_f64(f64::from(start) / (3.0 * hz));
        let lengths = core::iter::once(first).chain(frames.lengths(watched));
        Self { app, lengths: Box::new(lengths) }
    }

    /// The world of it.
    pub fn world(&mut self) -> &mut World {
        self.app.world_mut()
    }

    /// Spawns a thing, as a child of another if there is one.
    pub fn spawn(&mut self, bundle: impl Bundle, parent: Option<Entity>) -> Entity {
        let entity = self.world().spawn(bundle).id();
        if let Some(parent) = parent {
            self.world().entity_mut(entity).insert(ChildOf(parent));
        }
        entity
    }

    /// Spawns a cloth.
    pub fn spawn_cloth(&mut self, mesh: Mesh, bundle: impl Bundle, parent: Option<Entity>) -> Entity {
        let mesh = Mesh3d(self.world().resource_mut::<Assets<Mesh>>().add(mesh));
        self.spawn((mesh, ClothMesh::default(), bundle), parent)
    }

    /// Draws a frame.
    pub fn frame(&mut self) {
        let length = self.lengths.next().expect("frames never end");
        self.world().insert_resource(TimeUpdateStrategy::ManualDuration(length));
        self.app.update();
    }

    /// Draws frames for so many seconds of the game.
    pub fn run(&mut self, seconds: f64) {
        self.run_and(seconds, |_| {});
    }

    /// The same, with something to do after each.
    pub fn run_and(&mut self, seconds: f64, mut after: impl FnMut(&mut Self)) {
        let end = self.time() + seconds;
        while self.time() < end {
            self.frame();
            after(self);
        }
    }

    /// Draws so many frames while time stands.
    pub fn pause_for(&mut self, frames: u32) {
        self.world().resource_mut::<Time<Virtual>>().pause();
        for _ in 0..frames {
            self.frame();
        }
    }

    /// Lets time go on.
    pub fn unpause(&mut self) {
        self.world().resource_mut::<Time<Virtual>>().unpause();
    }

    /// Seconds since the start of the game.
    pub fn time(&mut self) -> f64 {
        self.world().resource::<Time<Virtual>>().elapsed_secs_f64()
    }

    /// The worst since it was last asked for.
    pub fn take_seen(&mut self) -> Seen {
        core::mem::take(&mut *self.world().resource_mut::<Seen>())
    }

    /// The simulation of a cloth.
    ///
    /// # Panics
    /// If it does not run.
    pub fn state(&self, cloth: Entity) -> &ClothState {
        self.app.world().get(cloth).expect("the cloth runs")
    }

    /// Where the vertices of a cloth are simulated.
    pub fn positions(&self, cloth: Entity) -> &[DVec3] {
        self.state(cloth).cloth().positions()
    }

    /// From the space of an entity to the world, as it is drawn.
    pub fn place(&self, entity: Entity) -> &GlobalTransform {
        self.app.world().get(entity).expect("it has a place")
    }

    /// What is drawn of a cloth is said to be within.
    pub fn bounds(&self, cloth: Entity) -> &Aabb {
        self.app.world().get(cloth).expect("it has bounds")
    }

    /// Where the vertices of a mesh are drawn, in the space of their entity.
    pub fn drawn(&self, cloth: Entity) -> &[[f32; 3]] {
        let mesh = self.app.world().get::<Mesh3d>(cloth).expect("it has a mesh");
        let mesh = self.app.world().resource::<Assets<Mesh>>().get(&mesh.0).expect("the mesh is there");
        match mesh.attribute(Mesh::ATTRIBUTE_POSITION) {
            Some(VertexAttributeValues::Float32x3(positions)) => positions,
            other => panic!("{other:?}"),
        }
    }

    /// The same in the world, m.
    pub fn drawn_in_world(&self, cloth: Entity) -> Vec<DVec3> {
        let affine = self.place(cloth).affine().as_daffine3();
        self.drawn(cloth).iter().map(|&p| affine.transform_point3(Vec3::from(p).as_dvec3())).collect()
    }
}

/// A sheet in the plane z = 0, its top edge around the origin, of n × n cells.
pub fn sheet(width: f32, height: f32, cells: u32) -> Mesh {
    let plane = Plane3d::new(Vec3::Z, 0.5 * Vec2::new(width, height));
    plane.mesh().subdivisions(cells - 1).build().translated_by(Vec3::NEG_Y * 0.5 * height)
}

/// Holds a [`sheet`] at its top edge.
pub fn top_edge() -> ClothPins {
    ClothPins::where_position(|p| p.y > -1e-4)
}

fn moves(app: &mut App, schedule: impl ScheduleLabel, when: When) {
    let system = move |time: Res<Time>, mut moved: Query<(&Moved, &mut Transform)>| {
        for (Moved(paths), mut transform) in &mut moved {
            for (_, path) in paths.iter().filter(|(there, _)| *there == when) {
                path(time.elapsed_secs_f64(), &mut transform);
            }
        }
    };
    app.add_systems(schedule, system.before(TransformSystems::Propagate).before(ClothSystems::Collect));
}

fn look(cloths: Query<&ClothState>, mut seen: ResMut<Seen>) {
    for state in &cloths {
        let cloth = state.cloth();
        let fastest = cloth.velocities().iter().map(|v| v.length()).fold(0.0, worse);
        seen.fastest = worse(seen.fastest, fastest);
        seen.stretch = worse(seen.stretch, cloth.stretch().max);
    }
}

/// The larger; what is not a number is the worst.
pub fn worse(a: f64, b: f64) -> f64 {
    if a.is_nan() || b.is_nan() { f64::INFINITY } else { a.max(b) }
}

/// How much a picture shakes: by the second differences of what is drawn.
#[derive(Clone, Debug, Default)]
pub struct Shake {
    before: Vec<[f32; 3]>,
    last: Vec<[f32; 3]>,
    squares: f64,
    count: usize,
    /// The most, m.
    pub most: f64,
}

impl Shake {
    /// Looks at the next picture.
    pub fn see(&mut self, drawn: &[[f32; 3]]) {
        if self.before.len() == drawn.len() {
            for ((&a, &b), &c) in self.before.iter().zip(&self.last).zip(drawn) {
                let [a, b, c] = [a, b, c].map(|p| Vec3::from(p).as_dvec3());
                let second = (a - 2.0 * b + c).length();
                self.squares += second * second;
                self.most = worse(self.most, second);
            }
            self.count += drawn.len();
        }
        self.before = core::mem::replace(&mut self.last, drawn.to_vec());
    }

    /// Root mean square over vertices and pictures, m.
    pub fn rms(&self) -> f64 {
        (self.squares / self.count as f64).sqrt()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_is_moved_is_where_its_schedule_says() {
        let mut stage = Stage::new(64.0, Frames::Even(60.0), 0.0, 1);
        let forth = path(|time, transform| transform.translation.x = time as f32);
        let everywhere = [When::FixedUpdate, When::PreUpdate, When::Update, When::Animation];
        let things = everywhere.map(|when| stage.spawn((Transform::IDENTITY, Moved::by(when, &forth)), None));
        stage.run(1.0);
        let now = stage.time() as f32;
        let [fixed, pre, update, animation] = things.map(|thing| stage.place(thing).translation().x);
        assert!(pre == now && update == now && animation == now, "{pre} {update} {animation} {now}");
        // 64 ticks and 60 frames both end after a second, so the last tick may be as late as the last frame.
        assert!(fixed <= now && now - fixed < 1.0 / 64.0, "{fixed} {now}");
    }

    #[test]
    fn an_even_motion_does_not_shake() {
        let mut shake = Shake::default();
        for k in 0..4_u8 {
            shake.see(&[[f32::from(k); 3]]);
        }
        assert!(shake.rms() == 0.0 && shake.most == 0.0);
        shake.see(&[[3.0; 3]]);
        assert!((shake.most - 3.0_f64.sqrt()).abs() < 1e-6);
        shake.see(&[[f32::NAN; 3]]);
        assert!(shake.most.is_infinite());
    }
}
