//! Colliders and touches, as lines.

use bevy::color::palettes::css;
use bevy::gizmos::gizmos::Gizmos;
use bevy::prelude::*;
use parry3d::shape::{Shape, TypedShape};

use super::outline::outline;
use super::{ClothGizmos, MARK};
use crate::physics::Pose;
use crate::plugin::contact::Track;
use crate::plugin::state::ClothState;

/// Lines on either side of the origin of a half-space, 1 m apart.
const PLANE: u32 = 10;

pub(super) fn draw_colliders(mut gizmos: Gizmos<ClothGizmos>, colliders: Query<&Track>) {
    if gizmos.config.enabled && gizmos.config_ext.colliders {
        for (shape, pose) in colliders.iter().filter_map(Track::present) {
            draw_shape(&mut gizmos, &*shape.0, isometry(&pose));
        }
    }
}

fn draw_shape(gizmos: &mut Gizmos<ClothGizmos>, shape: &dyn Shape, at: Isometry3d) {
    match shape.as_typed_shape() {
        TypedShape::HalfSpace(half) => {
            let turn = Quat::from_rotation_arc(Vec3::Z, half.normal);
            let plane = at * Isometry3d::from_rotation(turn);
            gizmos.grid(plane, UVec2::splat(2 * PLANE), Vec2::ONE, css::ORANGE);
        }
        TypedShape::Compound(compound) => {
            for (pose, part) in compound.shapes() {
                draw_shape(gizmos, &*part.0, at * Isometry3d::new(pose.translation, pose.rotation));
            }
        }
        shape => {
            let (points, lines) = outline(&shape);
            for [a, b] in lines {
                gizmos.line(at * points[a as usize], at * points[b as usize], css::ORANGE);
            }
        }
    }
}

pub(super) fn draw_contacts(mut gizmos: Gizmos<ClothGizmos>, cloths: Query<&ClothState>) {
    let newton = gizmos.config_ext.newton;
    if !(gizmos.config.enabled && gizmos.config_ext.contacts) {
        return;
    }
    for contact in cloths.iter().flat_map(|state| state.cloth.contacts()) {
        let (point, force) = (contact.point.as_vec3(), contact.force.as_vec3());
        gizmos.cross(Isometry3d::from_translation(point), 0.3 * MARK, css::RED);
        gizmos.line(point, point + contact.normal.as_vec3() * MARK, css::DEEP_SKY_BLUE);
        gizmos.arrow(point, point + force * newton, css::RED);
    }
}

fn isometry(pose: &Pose) -> Isometry3d {
    Isometry3d::new(pose.translation.as_vec3(), pose.rotation.as_quat())
}
