//! Colliders of Rapier. It has shapes of another version of parry: they are built again.

use bevy::ecs::schedule::InternedScheduleLabel;
use bevy::prelude::*;
use bevy_rapier3d::dynamics::{RigidBody, RigidBodyDisabled};
use bevy_rapier3d::geometry::{Collider, ColliderDisabled, ColliderView, Friction, Sensor};
use bevy_rapier3d::parry::math::Pose as TheirPose;
use bevy_rapier3d::parry::shape::{ShapeType, SharedShape as Theirs};
use parry3d::math::Pose;
use parry3d::shape::SharedShape;

use super::collider::ClothCollider;
use super::engines::{ClothPhysicsCollider, Suspended, suspend, take_over};
use super::error::{ClothColliderError, report};
use super::hull::hull;
use super::surface::{ground, surface};
use crate::plugin::ClothSystems;

pub(in crate::plugin) fn plugin(app: &mut App, schedule: InternedScheduleLabel) {
    app.add_observer(end).add_systems(
        schedule,
        adopt.before(super::rebuild).in_set(ClothSystems::Collect).run_if(any_with_component::<ClothPhysicsCollider>),
    );
}

type Marked<'a> = (
    NameOrEntity,
    Ref<'a, Collider>,
    Option<&'a Friction>,
    Option<&'a ClothCollider>,
    Option<&'a Suspended>,
    Option<&'a ClothColliderError>,
    Has<Sensor>,
    Has<ColliderDisabled>,
);

/// Takes over shapes as they are before scale, which cloth applies itself.
fn adopt(
    mut commands: Commands,
    colliders: Query<Marked, With<ClothPhysicsCollider>>,
    bodies: Query<Has<RigidBodyDisabled>, With<RigidBody>>,
    parents: Query<&ChildOf>,
) {
    for (name, collider, friction, current, suspended, shown, sensor, disabled) in &colliders {
        // The body of a collider is the nearest entity above it that is one.
        let mut above = core::iter::once(name.entity).chain(parents.iter_ancestors(name.entity));
        let body_disabled = above.find_map(|entity| bodies.get(entity).ok()) == Some(true);
        if sensor || disabled || body_disabled {
            suspend(&mut commands, name.entity, current);
            continue;
        }
        let friction = friction.map(|friction| friction.coefficient);
        if let Some(current) = current.filter(|_| !collider.is_changed()) {
            take_over(&mut commands, name.entity, Some(current), suspended, current.shape(), friction);
        } else if let Some(shape) = rebuilt(&collider.raw, &|| collider.as_unscaled_typed_shape()) {
            take_over(&mut commands, name.entity, current, suspended, &shape, friction);
        } else {
            if let Ok(mut entity) = commands.get_entity(name.entity) {
                entity.try_remove::<ClothCollider>();
            }
            let shape = format!("{:?}", collider.raw.shape_type());
            report(&mut commands, &name, shown, Some(ClothColliderError::Unsupported { shape }));
        }
    }
}

/// Takes the collider of cloth away with that of the engine.
fn end(removed: On<Remove, Collider>, marked: Query<(), With<ClothPhysicsCollider>>, mut commands: Commands) {
    if marked.contains(removed.entity)
        && let Ok(mut entity) = commands.get_entity(removed.entity)
    {
        entity.try_remove::<(ClothCollider, ClothColliderError)>();
    }
}

/// The same shape. Ground becomes a mesh that is solid from above; `None` for voxels and shapes of users, which have no view.
fn rebuilt<'a>(theirs: &Theirs, view: &dyn Fn() -> ColliderView<'a>) -> Option<SharedShape> {
    if theirs.shape_type() == ShapeType::Custom {
        return None;
    }
    Some(match view() {
        ColliderView::Ball(ball) => SharedShape::ball(ball.raw.radius),
        ColliderView::Cuboid(cuboid) => {
            let half = cuboid.raw.half_extents;
            SharedShape::cuboid(half.x, half.y, half.z)
        }
        ColliderView::Capsule(capsule) => {
            SharedShape::capsule(capsule.raw.segment.a, capsule.raw.segment.b, capsule.raw.radius)
        }
        ColliderView::Segment(segment) => SharedShape::segment(segment.raw.a, segment.raw.b),
        ColliderView::Triangle(triangle) => SharedShape::triangle(triangle.raw.a, triangle.raw.b, triangle.raw.c),
        ColliderView::TriMesh(mesh) => surface(mesh.raw.vertices(), mesh.raw.indices()).ok()?,
        ColliderView::Polyline(line) => {
            SharedShape::polyline(line.raw.vertices().to_vec(), Some(line.raw.indices().to_vec()))
        }
        ColliderView::HalfSpace(half) => SharedShape::halfspace(half.raw.normal),
        ColliderView::HeightField(field) => {
            let (vertices, triangles) = ground(field.raw.to_trimesh());
            surface(&vertices, &triangles).ok()?
        }
        ColliderView::Compound(compound) => {
            let part = |(pose, part): &(TheirPose, Theirs)| {
                let pose = Pose::from_parts(pose.translation, pose.rotation);
                Some((pose, rebuilt(part, &|| part.as_typed_shape().into())?))
            };
            SharedShape::compound(compound.raw.shapes().iter().map(part).collect::<Option<_>>()?)
        }
        ColliderView::ConvexPolyhedron(body) => hull(body.raw.points()).ok()?,
        ColliderView::Cylinder(cylinder) => SharedShape::cylinder(cylinder.raw.half_height, cylinder.raw.radius),
        ColliderView::Cone(cone) => SharedShape::cone(cone.raw.half_height, cone.raw.radius),
        ColliderView::RoundCuboid(round) => {
            let half = round.raw.inner_shape.half_extents;
            SharedShape::round_cuboid(half.x, half.y, half.z, round.raw.border_radius)
        }
        ColliderView::RoundTriangle(round) => {
            let inner = round.raw.inner_shape;
            SharedShape::round_triangle(inner.a, inner.b, inner.c, round.raw.border_radius)
        }
        ColliderView::RoundCylinder(round) => {
            let inner = round.raw.inner_shape;
            SharedShape::round_cylinder(inner.half_height, inner.radius, round.raw.border_radius)
        }
        ColliderView::RoundCone(round) => {
            let inner = round.raw.inner_shape;
            SharedShape::round_cone(inner.half_height, inner.radius, round.raw.border_radius)
        }
        ColliderView::RoundConvexPolyhedron(round) => {
            SharedShape::round_convex_hull(round.raw.inner_shape.points(), round.raw.border_radius)?
        }
        ColliderView::Voxels(_) => return None,
    })
}
