//! A camera that orbits a point: drag to turn, wheel to zoom, right drag to move the point.

use bevy::{
    camera::Hdr,
    core_pipeline::tonemapping::Tonemapping,
    input::mouse::{AccumulatedMouseMotion, AccumulatedMouseScroll, MouseScrollUnit},
    prelude::*,
};
use std::f32::consts::FRAC_PI_2;

/// Turns with the mouse around `focus`. The [`Transform`] follows from these numbers.
#[derive(Component, Clone, Copy, Debug)]
// In HDR the backdrop goes through the same tone mapping as what fades into it; this one keeps the colours of the cloth
// and needs no look-up table.
#[require(Camera3d, Hdr, Tonemapping::KhronosPbrNeutral)]
pub struct OrbitCamera {
    /// The point looked at, in metres.
    pub focus: Vec3,
    /// Distance from the focus, in metres.
    pub distance: f32,
    /// Angle around the vertical, in radians; 0 looks along −z.
    pub yaw: f32,
    /// Angle above the horizon, in radians.
    pub pitch: f32,
}

impl OrbitCamera {
    /// Where the camera stands.
    pub fn transform(&self) -> Transform {
        let rotation = Quat::from_euler(EulerRot::YXZ, self.yaw, -self.pitch, 0.0);
        Transform::from_translation(self.focus + rotation * Vec3::Z * self.distance).with_rotation(rotation)
    }
}

/// Moves every [`OrbitCamera`] with the mouse.
pub struct OrbitCameraPlugin;

impl Plugin for OrbitCameraPlugin {
    fn build(&self, app: &mut App) {
        app.add_systems(Update, (follow_mouse, place).chain());
    }
}

const RADIANS_PER_PIXEL: f32 = 0.006;
const ZOOM_PER_LINE: f32 = 0.12;
const LINES_PER_PIXEL: f32 = 0.01;

fn follow_mouse(
    mut cameras: Query<&mut OrbitCamera>,
    buttons: Res<ButtonInput<MouseButton>>,
    motion: Res<AccumulatedMouseMotion>,
    scroll: Res<AccumulatedMouseScroll>,
) {
    let lines = match scroll.unit {
        MouseScrollUnit::Line => scroll.delta.y,
        MouseScrollUnit::Pixel => scroll.delta.y * LINES_PER_PIXEL,
    };
    let turn = buttons.pressed(MouseButton::Left);
    let shift = buttons.pressed(MouseButton::Right);
    if lines == 0.0 && (motion.delta == Vec2::ZERO || !(turn || shift)) {
        return;
    }
    for mut camera in &mut cameras {
        camera.distance *= (-ZOOM_PER_LINE * lines).exp();
        if turn {
            camera.yaw -= motion.delta.x * RADIANS_PER_PIXEL;
            // Straight up or down the heading would flip.
            let steepest = FRAC_PI_2 - 0.01;
            camera.pitch = (camera.pitch + motion.delta.y * RADIANS_PER_PIXEL).clamp(-steepest, steepest);
        }
        if shift {
            let rotation = camera.transform().rotation;
            let metres_per_pixel = camera.distance * 0.001;
            let in_view = Vec3::new(-motion.delta.x, motion.delta.y, 0.0) * metres_per_pixel;
            camera.focus += rotation * in_view;
        }
    }
}

fn place(mut cameras: Query<(&OrbitCamera, &mut Transform), Changed<OrbitCamera>>) {
    for (camera, mut transform) in &mut cameras {
        *transform = camera.transform();
    }
}
