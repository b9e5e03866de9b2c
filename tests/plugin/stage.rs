//! A wearer, a cape and what moves them, at any rate: for the tests of motion, jumps and pictures.

use std::time::Duration;

use bevy::prelude::*;
use bevy::time::TimeUpdateStrategy;
use bevy_cloth::plugin::*;

use crate::common::*;

/// Where the wearer is moved.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Mover {
    FixedUpdate,
    Update,
    /// As `AnimationPlayer` does.
    PostUpdate,
}

impl Mover {
    pub const ALL: [Self; 3] = [Self::FixedUpdate, Self::Update, Self::PostUpdate];
}

/// The pose of everything marked with it, by its time, s.
#[derive(Component, Clone, Copy)]
pub struct Moved(pub fn(f32) -> Transform);

fn follow(time: Res<Time>, mut moved: Query<(&Moved, &mut Transform)>) {
    for (moved, mut transform) in &mut moved {
        *transform = (moved.0)(time.elapsed_secs());
    }
}

/// An app with the default plugin at this rate of ticks (Hz), whose [`Moved`] are moved by `mover`.
pub fn app_at(hz: f64, mover: Mover) -> App {
    let mut app = app_with(ClothPlugin::default());
    app.insert_resource(Time::<Fixed>::from_hz(hz));
    match mover {
        Mover::FixedUpdate => app.add_systems(FixedUpdate, follow.before(ClothSystems::Collect)),
        Mover::Update => app.add_systems(Update, follow),
        Mover::PostUpdate => app.add_systems(PostUpdate, follow.before(TransformSystems::Propagate)),
    };
    app
}

/// Makes a frame of `seconds`.
pub fn frame(app: &mut App, seconds: f64) {
    app.insert_resource(TimeUpdateStrategy::ManualDuration(Duration::from_secs_f64(seconds)));
    app.update();
}

/// A cape of 0.8 m and `cells` cells a side, its top edge from (-0.4, 0, z) to (0.4, 0, z).
pub fn cape(cells: u32, z: f32) -> Mesh {
    Plane3d::new(Vec3::Z, Vec2::splat(0.4))
        .mesh()
        .subdivisions(cells - 1)
        .build()
        .translated_by(Vec3::new(0.0, -0.4, z))
}

/// Its top edge.
pub fn collar() -> ClothPins {
    ClothPins::where_position(|p| p.y > -1e-4)
}

/// Largest stretch and fastest vertex so far, m/s.
#[derive(Clone, Copy, Debug, Default)]
pub struct Worst {
    pub stretch: f64,
    pub speed: f64,
}

impl Worst {
    /// Looks at the cloth as it is simulated now; its velocities count against `base`.
    pub fn look(&mut self, app: &App, cloth: Entity, base: Vec3) {
        let cloth = state(app, cloth).cloth();
        let against = |v: &bevy::math::DVec3| v.distance(base.as_dvec3());
        self.stretch = self.stretch.max(cloth.stretch().max);
        self.speed = cloth.velocities().iter().map(against).fold(self.speed, f64::max);
    }
}
