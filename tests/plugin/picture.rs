//! What is drawn is what was simulated: found by a curtain that was drawn 4 cm inside a capsule that it never touched.

use bevy::camera::primitives::Aabb;
use bevy::prelude::*;
use bevy_cloth::plugin::*;

use crate::common::*;
use crate::stage::*;

fn swings(t: f32) -> Transform {
    Transform::from_xyz(0.6 * (2.1 * t).sin(), 1.0, 0.0)
}

fn stands(t: f32) -> Transform {
    Transform::from_xyz(0.1 + 0.0 * t, 0.4, 0.12)
}

fn walks(t: f32) -> Transform {
    Transform::from_xyz(0.1, 0.4, 0.5 * (2.1 * t).cos())
}

/// How deep any drawn vertex is in a drawn capsule along y at most, m, over the last part of a run; and whether the box holds it all.
fn deepest(mover: Mover, fps: f64, rod: fn(f32) -> Transform, body: fn(f32) -> Transform) -> f32 {
    const RADIUS: f32 = 0.1;
    let mut app = app_at(64.0, mover);
    let holder = app.world_mut().spawn((rod(0.0), Moved(rod))).id();
    let capsule = app.world_mut().spawn((ClothCollider::capsule(RADIUS, 0.6), body(0.0), Moved(body))).id();
    let cloth = spawn(&mut app, cape(16, 0.0), (collar(), ChildOf(holder)));
    let mut deepest: f32 = 0.0;
    for _ in 0..(3.0 * fps) as usize {
        frame(&mut app, 1.0 / fps);
        let at = app.world().get::<GlobalTransform>(capsule).unwrap().translation();
        let aabb = *app.world().get::<Aabb>(cloth).unwrap();
        for (vertex, (world, local)) in world(&app, cloth).into_iter().zip(local(&app, cloth)).enumerate() {
            let off = world - at;
            let axis = Vec3::Y * off.y.clamp(-0.3, 0.3);
            deepest = deepest.max(RADIUS - off.distance(axis));
            let beyond = (local - Vec3::from(aabb.center)).abs() - Vec3::from(aabb.half_extents);
            assert!(beyond.max_element() < 1e-5, "the box holds all that is drawn");
            if vertex < 17 {
                assert_near(
                    local,
                    cape(16, 0.0).attribute(Mesh::ATTRIBUTE_POSITION).unwrap().as_float3().unwrap()[vertex].into(),
                    1e-6,
                );
            }
        }
    }
    deepest
}

#[test]
fn a_curtain_is_not_drawn_inside_of_what_it_never_entered() {
    for mover in Mover::ALL {
        for fps in [30.0, 60.0, 144.0] {
            for (case, rod, body) in [
                ("rod", swings as fn(f32) -> Transform, stands as fn(f32) -> Transform),
                ("body", |_| Transform::from_xyz(0.0, 1.0, 0.0), walks),
            ] {
                let deep = deepest(mover, fps, rod, body);
                assert!(deep <= 1e-3, "{case} moved in {mover:?} at {fps}: {} mm", 1e3 * deep);
            }
        }
    }
}

#[test]
fn what_lies_on_a_lift_is_drawn_on_it() {
    let lift = |t: f32| Transform::from_xyz(0.0, 0.5 * (3.0 * t).sin(), 0.0);
    for mover in Mover::ALL {
        for fps in [30.0, 60.0, 144.0] {
            let mut app = app_at(64.0, mover);
            let floor = app.world_mut().spawn((ClothCollider::cuboid(3.0, 0.2, 3.0), lift(0.0), Moved(lift))).id();
            let sheet = Plane3d::new(Vec3::Y, Vec2::splat(0.4)).mesh().subdivisions(7).build();
            let cloth = spawn(&mut app, sheet, Transform::from_xyz(0.0, 0.12, 0.0));
            let (mut inside, mut above): (f32, f32) = (0.0, 0.0);
            for i in 0..(3.0 * fps) as usize {
                frame(&mut app, 1.0 / fps);
                let top = app.world().get::<GlobalTransform>(floor).unwrap().translation().y + 0.1;
                for p in world(&app, cloth).iter().filter(|_| i > fps as usize) {
                    inside = inside.max(top - p.y);
                    above = above.max(p.y - top);
                }
            }
            assert!(inside <= 1e-3 && above <= 0.03, "{mover:?} {fps}: {inside} m inside, {above} m above");
        }
    }
}

/// Avian moves its bodies in `FixedPostUpdate`, after the cloth was stepped: found by a ball that was drawn through a hammock from below.
#[cfg(feature = "avian3d")]
#[test]
fn bodies_of_an_engine_are_not_drawn_through_the_cloth_that_carries_them() {
    use avian3d::prelude::{Collider, Gravity, PhysicsPlugins, RigidBody, TransformInterpolation};
    for eased in [false, true] {
        for fps in [30.0, 60.0, 144.0] {
            let mut app = app_with((PhysicsPlugins::default(), ClothPlugin::default()));
            app.insert_resource(Gravity(Vec3::NEG_Y * 9.81));
            let mesh = Plane3d::new(Vec3::Y, Vec2::new(1.0, 0.5)).mesh().subdivisions(15).build();
            let ends = ClothPins::where_position(|p| p.x.abs() > 0.999);
            let cloth = spawn(&mut app, mesh, (ends, ClothMaterial::canvas(), Transform::from_xyz(0.0, 1.0, 0.0)));
            let body = (RigidBody::Kinematic, Collider::sphere(0.2), ClothPhysicsCollider);
            let velocity = avian3d::prelude::LinearVelocity(Vec3::NEG_Y * 2.0);
            let ball = app.world_mut().spawn((body, velocity, Transform::from_xyz(0.0, 1.5, 0.0))).id();
            if eased {
                app.world_mut().entity_mut(ball).insert(TransformInterpolation);
            }
            let mut deepest: f32 = 0.0;
            for _ in 0..(0.25 * fps) as usize {
                frame(&mut app, 1.0 / fps);
                let at = app.world().get::<GlobalTransform>(ball).unwrap().translation();
                deepest = world(&app, cloth).iter().map(|p| 0.2 - p.distance(at)).fold(deepest, f32::max);
            }
            assert!(deepest < 2e-3, "eased {eased}, {fps} frames a second: {} mm inside", 1e3 * deepest);
        }
    }
}
