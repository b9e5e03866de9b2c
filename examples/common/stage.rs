//! Ground, light and backdrop for a scene of any size.

use bevy::{
    light::CascadeShadowConfigBuilder,
    pbr::{DistanceFog, FogFalloff},
    prelude::*,
};

/// The backdrop, and what the ground fades to.
const BACKDROP: Color = Color::srgb(0.76, 0.79, 0.82);
const GROUND: Color = Color::srgb(0.47, 0.47, 0.48);

/// Where the scene stands and how large it is.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Stage {
    /// A point of the ground under the scene, in metres.
    pub floor: Vec3,
    /// Radius of a ball around the scene, in metres.
    pub radius: f32,
    /// Heading of the camera, in radians, like [`yaw`](crate::orbit_camera::OrbitCamera::yaw): the light comes from its
    /// left.
    pub yaw: f32,
}

impl Stage {
    /// Adds ground and lights, and lets `camera` see them fade into the backdrop.
    pub fn build(self, world: &mut World, camera: Entity) {
        let ground = world.resource_mut::<Assets<Mesh>>().add(Circle::new(40.0 * self.radius));
        let surface = world.resource_mut::<Assets<StandardMaterial>>().add(StandardMaterial {
            base_color: GROUND,
            perceptual_roughness: 0.95,
            reflectance: 0.2,
            ..default()
        });
        world.spawn((
            Name::new("Ground"),
            Mesh3d(ground),
            MeshMaterial3d(surface),
            Transform::from_translation(self.floor).looking_to(Vec3::NEG_Y, Vec3::Z),
        ));

        let cascades = CascadeShadowConfigBuilder {
            // With only one, OpenGL takes the array of shadow maps for a plain texture and all is shadow.
            num_cascades: 2,
            first_cascade_far_bound: 4.0 * self.radius,
            maximum_distance: 10.0 * self.radius,
            ..default()
        };
        let shining = |x, y, z| {
            let along = Quat::from_rotation_y(self.yaw) * Vec3::new(x, y, z);
            Transform::default().looking_to(along, Vec3::Y)
        };
        // Raking key light from the front left: folds show best when lit from the side.
        world.spawn((
            Name::new("Key light"),
            DirectionalLight {
                color: Color::srgb(1.0, 0.95, 0.88),
                illuminance: 8_500.0,
                shadow_maps_enabled: true,
                // Folds must not shade themselves where the light grazes them.
                shadow_normal_bias: 4.0,
                ..default()
            },
            cascades.build(),
            shining(0.95, -0.85, -0.3),
        ));
        world.spawn((
            Name::new("Fill light"),
            DirectionalLight { color: Color::srgb(0.80, 0.88, 1.0), illuminance: 1_800.0, ..default() },
            shining(-0.6, -0.25, -0.7),
        ));
        world.spawn((
            Name::new("Back light"),
            DirectionalLight { color: Color::srgb(1.0, 0.97, 0.92), illuminance: 2_500.0, ..default() },
            shining(-0.5, -0.6, 0.8),
        ));

        world.insert_resource(ClearColor(BACKDROP));
        world.insert_resource(GlobalAmbientLight { brightness: 350.0, ..default() });
        world.entity_mut(camera).insert(DistanceFog {
            color: BACKDROP,
            falloff: FogFalloff::Linear { start: 6.0 * self.radius, end: 22.0 * self.radius },
            ..default()
        });
    }
}
