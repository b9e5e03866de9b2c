//! Many cloths in view of a camera, at many distances, that never come to rest.

use std::f32::consts::TAU;
use std::time::{Duration, Instant};

use bevy::camera::primitives::Aabb;
use bevy::mesh::{MeshPlugin, VertexAttributeValues};
use bevy::prelude::*;
use bevy::time::TimeUpdateStrategy;
use bevy_cloth::plugin::{ClothMaterial, ClothMesh, ClothPins, ClothPlugin, ClothQuality, ClothState, ClothSystems};

use crate::scenes::{DT, Meshing, Sheet, fabric};

/// Cloths in a row across.
const ACROSS: usize = 10;
/// Between rows and between the cloths of one, m.
const SPACING: f32 = 1.5;
/// How far their entities sway to either side, m, and how often, Hz.
const SWAY: f32 = 0.3;
const SWAY_RATE: f32 = 0.6;

/// Which cloth it is, the nearest first; it is held by something that sways.
#[derive(Component)]
pub struct Index(pub usize);

/// When the last update reached each stage.
#[derive(Resource, Clone, Copy)]
struct Marks([Instant; 4]);

fn mark<const WHICH: usize>(mut marks: ResMut<Marks>) {
    marks.0[WHICH] = Instant::now();
}

/// An app in which an update is a step of `cloths` sheets of `side` × `side` vertices.
pub struct Scene {
    /// The app; what is spawned and despawned in it is up to the reader.
    pub app: App,
    shown: Vec<Vec<Vec3>>,
}

impl Scene {
    /// The first frame is still to come.
    pub fn new(cloths: usize, side: u32) -> Self {
        let mut app = App::new();
        app.add_plugins((MinimalPlugins, TransformPlugin, AssetPlugin::default(), MeshPlugin, ClothPlugin::default()))
            .insert_resource(TimeUpdateStrategy::FixedTimesteps(1))
            .insert_resource(Time::<Fixed>::from_seconds(DT))
            .insert_resource(Marks([Instant::now(); 4]))
            .add_systems(
                FixedUpdate,
                ((sway, mark::<0>).chain().before(ClothSystems::Collect), mark::<1>.after(ClothSystems::Step)),
            )
            .add_systems(
                PostUpdate,
                (
                    mark::<2>.after(ClothSystems::Initialise).before(ClothSystems::WriteBack),
                    mark::<3>.after(ClothSystems::WriteBack),
                ),
            );
        let sheet = Sheet::new(side, Meshing::Grid);
        let mesh = app.world_mut().resource_mut::<Assets<Mesh>>().add(sheet.mesh());
        app.world_mut().spawn((Camera3d::default(), Transform::from_xyz(0.0, 0.0, 3.0)));
        for index in 0..cloths {
            app.world_mut().spawn((
                Index(index),
                Mesh3d(mesh.clone()),
                place(index, 0.0),
                ClothMesh::default(),
                ClothMaterial(fabric()),
                ClothPins::indices(sheet.corners),
                Aabb::default(),
            ));
        }
        app.finish();
        app.cleanup();
        // The cloths start in the first update; in no more than two, time does not pass.
        for _ in 0..3 {
            app.update();
        }
        let mut scene = Self { app, shown: vec![Vec::new(); cloths] };
        scene.largest_move();
        scene
    }

    /// Takes a frame: how long the cloths took, and how far a shown vertex moved at most, m.
    pub fn frame(&mut self) -> (Duration, f32) {
        self.app.update();
        let Marks([begin, stepped, initialised, written]) = *self.app.world().resource::<Marks>();
        ((stepped - begin) + (written - initialised), self.largest_move())
    }

    /// Of all vertices since this was last asked for, m.
    fn largest_move(&mut self) -> f32 {
        let world = self.app.world_mut();
        let mut cloths = world.query::<(&Index, &Mesh3d, &GlobalTransform)>();
        let (world, mut largest) = (&*world, 0.0_f32);
        let meshes = world.resource::<Assets<Mesh>>();
        for (index, mesh, transform) in cloths.iter(world) {
            let Some(VertexAttributeValues::Float32x3(positions)) =
                meshes.get(mesh).and_then(|mesh| mesh.attribute(Mesh::ATTRIBUTE_POSITION))
            else {
                continue;
            };
            let now: Vec<_> = positions.iter().map(|&p| transform.transform_point(p.into())).collect();
            let before = std::mem::replace(&mut self.shown[index.0], now);
            for (now, before) in self.shown[index.0].iter().zip(before) {
                largest = largest.max(now.distance(before));
            }
        }
        largest
    }

    /// Update interval and level of each cloth that is there, by its index.
    pub fn levels(&mut self) -> Vec<Option<(u32, ClothQuality)>> {
        let mut levels = vec![None; self.shown.len()];
        let world = self.app.world_mut();
        let mut cloths = world.query::<(&Index, &ClothState)>();
        for (index, state) in cloths.iter(world) {
            levels[index.0] = Some((state.update_interval(), state.quality().unwrap_or_default()));
        }
        levels
    }

    /// Takes away all but the nearest.
    pub fn keep(&mut self, count: usize) {
        let world = self.app.world_mut();
        let mut cloths = world.query::<(Entity, &Index)>();
        let gone: Vec<_> = cloths.iter(world).filter(|(_, index)| index.0 >= count).map(|(entity, _)| entity).collect();
        for entity in gone {
            world.despawn(entity);
        }
    }
}

fn place(index: usize, time: f32) -> Transform {
    let (row, column) = ((index / ACROSS) as f32, (index % ACROSS) as f32);
    let swayed = SWAY * (TAU * (SWAY_RATE * time + 0.37 * index as f32)).sin();
    let centre = 0.5 * (ACROSS - 1) as f32;
    Transform::from_xyz(SPACING * (column - centre), 0.0, swayed - SPACING * row)
}

fn sway(time: Res<Time>, mut cloths: Query<(&Index, &mut Transform)>) {
    for (index, mut transform) in &mut cloths {
        *transform = place(index.0, time.elapsed_secs());
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_cloths_keep_moving_and_can_be_taken_away() {
        let mut scene = Scene::new(12, 5);
        for _ in 0..120 {
            scene.frame();
        }
        let (time, moved) = scene.frame();
        assert!(!time.is_zero() && (0.002..0.2).contains(&moved), "{moved}");
        scene.keep(4);
        assert_eq!(scene.levels().iter().flatten().count(), 4);
    }
}
