//! A figure of capsules, its limbs on joints.

use crate::gait::{Gait, Joint, Side};
use bevy::{ecs::system::SystemParam, prelude::*};
use example_common::props::{mesh, varnished};
use std::f32::consts::{FRAC_PI_2, TAU};

/// Of the circle that the figures walk on, in metres.
const CIRCLE: f32 = 1.1;

/// What makes a figure and its parts solid.
#[derive(Clone, Copy)]
pub struct Bodies {
    /// Adds the physics engine that they belong to, if any.
    pub engine: fn(&mut App),
    pub figure: fn(&mut EntityWorldMut),
    /// The capsule is that of the part.
    pub part: fn(&mut EntityWorldMut, Capsule3d),
}

/// Walks on the circle, with its feet at the origin, forwards along +z.
#[derive(Component)]
pub struct Figure {
    /// Where on the circle it starts, as a share of it.
    start: f32,
}

/// All that is posed.
#[derive(SystemParam)]
pub struct Figures<'w, 's> {
    figures: Query<'w, 's, (&'static Figure, &'static Children, &'static mut Transform), Without<Joint>>,
    joints: Query<'w, 's, (&'static Joint, &'static mut Transform)>,
    children: Query<'w, 's, &'static Children>,
}

impl Figures<'_, '_> {
    /// As they are so many seconds after they set off.
    pub fn pose(&mut self, seconds: f32) {
        for (figure, parts, mut transform) in &mut self.figures {
            let gait = Gait::at(seconds, figure.start);
            let angle = TAU * figure.start + gait.way / CIRCLE;
            let turn = Quat::from_rotation_y(angle);
            transform.translation = turn * (CIRCLE * Vec3::Z) + gait.rise() * Vec3::Y;
            transform.rotation = turn * Quat::from_rotation_y(FRAC_PI_2);
            let limbs = parts.iter().flat_map(|part| [part].into_iter().chain(self.children.iter_descendants(part)));
            for limb in limbs {
                if let Ok((joint, mut transform)) = self.joints.get_mut(limb) {
                    transform.rotation = Quat::from_rotation_x(-gait.bend(*joint));
                }
            }
        }
    }
}

/// Spawns a figure that starts at this share of the circle.
pub fn build(world: &mut World, start: f32, bodies: Bodies) -> Entity {
    let mut figure = world.spawn((Name::new("Figure"), Figure { start }, Transform::default(), Visibility::default()));
    (bodies.figure)(&mut figure);
    let figure = figure.id();
    let skin = varnished(world, Color::srgb(0.78, 0.76, 0.72));
    let mut builder = Builder { world, skin, bodies };

    let lying = Quat::from_rotation_z(FRAC_PI_2);
    let fixed = |x, y, z| Transform::from_xyz(x, y, z);
    builder.part(figure, Capsule3d::new(0.1, 0.11), fixed(0.0, 0.93, 0.0).with_rotation(lying));
    builder.part(figure, Capsule3d::new(0.122, 0.22), fixed(0.0, 1.17, 0.0));
    builder.part(figure, Capsule3d::new(0.078, 0.25), fixed(0.0, 1.385, 0.0).with_rotation(lying));
    builder.part(figure, Capsule3d::new(0.048, 0.10), fixed(0.0, 1.51, 0.0));
    builder.part(figure, Capsule3d::new(0.10, 0.05), fixed(0.0, 1.67, 0.01));
    for side in [Side::Left, Side::Right] {
        // Forwards is +z, so the left is +x.
        let x = if side == Side::Left { 1.0 } else { -1.0 };
        let hip = builder.limb(figure, Joint::Hip(side), Vec3::new(0.09 * x, 0.90, 0.0), 0.072, 0.42);
        let knee = builder.limb(hip, Joint::Knee(side), Vec3::new(0.0, -0.42, 0.0), 0.052, 0.40);
        let foot = Transform::from_xyz(0.0, -0.43, 0.06).with_rotation(Quat::from_rotation_x(FRAC_PI_2));
        builder.part(knee, Capsule3d::new(0.04, 0.14), foot);
        let shoulder = builder.limb(figure, Joint::Shoulder(side), Vec3::new(0.215 * x, 1.38, 0.01), 0.045, 0.29);
        builder.limb(shoulder, Joint::Elbow(side), Vec3::new(0.0, -0.29, 0.0), 0.038, 0.27);
    }
    let pose = |mut figures: Figures| figures.pose(0.0);
    world.run_system_cached(pose).expect("a system without conditions");
    figure
}

struct Builder<'w> {
    world: &'w mut World,
    skin: MeshMaterial3d<StandardMaterial>,
    bodies: Bodies,
}

impl Builder<'_> {
    fn part(&mut self, parent: Entity, capsule: Capsule3d, transform: Transform) {
        let mesh = mesh(self.world, capsule);
        let mut part = self.world.spawn((mesh, self.skin.clone(), transform, ChildOf(parent)));
        (self.bodies.part)(&mut part, capsule);
    }

    /// A joint, and the capsule that hangs from it; returns the joint.
    fn limb(&mut self, parent: Entity, joint: Joint, place: Vec3, radius: f32, length: f32) -> Entity {
        let transform = Transform::from_translation(place);
        let joint = self.world.spawn((joint, transform, Visibility::default(), ChildOf(parent))).id();
        self.part(joint, Capsule3d::new(radius, length), Transform::from_xyz(0.0, -0.5 * length, 0.0));
        joint
    }
}
