//! A headless app and a small mesh, for the tests of the plugin.

use std::collections::HashMap;

use bevy::app::Plugins;
use bevy::asset::AssetId;
use bevy::camera::CameraPlugin;
use bevy::mesh::{Indices, MeshPlugin, PrimitiveTopology, VertexAttributeValues};
use bevy::prelude::*;
use bevy::time::TimeUpdateStrategy;
use bevy_cloth::physics::{Collider, StepReport};
use bevy_cloth::plugin::*;

/// Cells along each side of [`sheet`].
pub const CELLS: u32 = 4;
/// Vertices of [`sheet`].
pub const COUNT: u32 = (CELLS + 1) * (CELLS + 1);

/// A square of 1 m in the plane z = 0, with normals and texture coordinates, its top edge from the origin along +x (vertices
/// 0 to [`CELLS`]), its rows downwards.
pub fn sheet() -> Mesh {
    let n = CELLS + 1;
    let point = |i: u32| ((i % n) as f32 / CELLS as f32, (i / n) as f32 / CELLS as f32);
    let corner = |i: u32| i % n < CELLS && i / n < CELLS;
    let cell = |i: u32| [i, i + n, i + 1, i + 1, i + n, i + n + 1];
    Mesh::new(PrimitiveTopology::TriangleList, default())
        .with_inserted_attribute(
            Mesh::ATTRIBUTE_POSITION,
            (0..n * n).map(|i| [point(i).0, -point(i).1, 0.0]).collect::<Vec<_>>(),
        )
        .with_inserted_attribute(Mesh::ATTRIBUTE_NORMAL, vec![[0.0, 0.0, 1.0]; COUNT as usize])
        .with_inserted_attribute(Mesh::ATTRIBUTE_UV_0, (0..n * n).map(|i| point(i).into()).collect::<Vec<[f32; 2]>>())
        .with_inserted_indices(Indices::U16(
            (0..n * n).filter(|&i| corner(i)).flat_map(cell).map(|i| i as u16).collect(),
        ))
}

/// The top edge of [`sheet`].
pub fn top_edge() -> ClothPins {
    ClothPins::where_position(|p| p.y > -0.01)
}

/// Modified events of each mesh since they were last taken.
#[derive(Resource, Default)]
pub struct Modified(pub HashMap<AssetId<Mesh>, usize>);

/// What Bevy's meshes need without a window, and these plugins. A frame is one fixed step.
pub fn app_with<M>(plugins: impl Plugins<M>) -> App {
    let mut app = App::new();
    app.add_plugins((MinimalPlugins, TransformPlugin, AssetPlugin::default(), MeshPlugin, CameraPlugin))
        .add_plugins(plugins)
        .insert_resource(TimeUpdateStrategy::FixedTimesteps(1))
        .init_resource::<Modified>()
        .add_systems(Last, |mut events: MessageReader<AssetEvent<Mesh>>, mut modified: ResMut<Modified>| {
            for event in events.read() {
                if let AssetEvent::Modified { id } = event {
                    *modified.0.entry(*id).or_default() += 1;
                }
            }
        });
    app.finish();
    app.cleanup();
    // Time does not pass in the first frame, nor fixed time in the second.
    run(&mut app, 2);
    app
}

/// As [`app_with`], without interpolation: a frame shows the step it took.
pub fn app() -> App {
    app_with(ClothPlugin::default().without_interpolation())
}

pub fn run(app: &mut App, frames: usize) {
    for _ in 0..frames {
        app.update();
    }
}

pub fn add_mesh(app: &mut App, mesh: Mesh) -> Handle<Mesh> {
    app.world_mut().resource_mut::<Assets<Mesh>>().add(mesh)
}

/// Spawns a cloth of `mesh` and lets it start (in the frame of it, there is no step).
pub fn spawn(app: &mut App, mesh: Mesh, bundle: impl Bundle) -> Entity {
    let mesh3d = Mesh3d(add_mesh(app, mesh));
    let entity = app.world_mut().spawn((mesh3d, ClothMesh::default(), bundle)).id();
    app.update();
    entity
}

pub fn mesh(app: &App, entity: Entity) -> &Mesh {
    let handle = &app.world().get::<Mesh3d>(entity).expect("a mesh").0;
    app.world().resource::<Assets<Mesh>>().get(handle).expect("a loaded mesh")
}

pub fn vectors(mesh: &Mesh, attribute: bevy::mesh::MeshVertexAttribute) -> Vec<Vec3> {
    match mesh.attribute(attribute) {
        Some(VertexAttributeValues::Float32x3(values)) => values.iter().map(|&v| v.into()).collect(),
        other => panic!("{other:?}"),
    }
}

/// Positions shown, in the space of the mesh.
pub fn local(app: &App, entity: Entity) -> Vec<Vec3> {
    vectors(mesh(app, entity), Mesh::ATTRIBUTE_POSITION)
}

/// Positions shown, in the world.
pub fn world(app: &App, entity: Entity) -> Vec<Vec3> {
    let transform = app.world().get::<GlobalTransform>(entity).expect("a transform");
    local(app, entity).into_iter().map(|p| transform.transform_point(p)).collect()
}

pub fn state(app: &App, entity: Entity) -> &ClothState {
    app.world().get::<ClothState>(entity).expect("a running cloth")
}

pub fn error(app: &App, entity: Entity) -> Option<&ClothError> {
    app.world().get::<ClothError>(entity)
}

/// How often the own mesh of a cloth was modified since this was last called.
pub fn take_modified(app: &mut App, entity: Entity) -> usize {
    let id = app.world().get::<Mesh3d>(entity).expect("a mesh").id();
    app.world_mut().resource_mut::<Modified>().0.remove(&id).unwrap_or(0)
}

#[track_caller]
pub fn assert_near(a: Vec3, b: Vec3, tolerance: f32) {
    assert!(a.distance(b) <= tolerance, "{a} is not {b}");
}

/// What each cloth was given in each of its steps.
#[derive(Resource, Default)]
pub struct Given {
    pub steps: HashMap<Entity, Vec<Vec<Collider>>>,
    /// Before the step of this tick, if there is one in it.
    before: HashMap<Entity, (Option<StepReport>, Vec<Collider>)>,
}

/// As [`app`], and takes note of the colliders in each step.
pub fn app_with_notes() -> App {
    let mut app = app();
    with_notes(&mut app);
    app
}

/// Takes note of the colliders in each step.
pub fn with_notes(app: &mut App) {
    app.init_resource::<Given>()
        .add_systems(FixedUpdate, note.after(ClothSystems::Collect).before(ClothSystems::Step))
        .add_systems(FixedUpdate, keep.after(ClothSystems::Step));
}

fn note(cloths: Query<(Entity, &ClothState)>, mut given: ResMut<Given>) {
    for (entity, state) in &cloths {
        let cloth = state.cloth();
        given.before.insert(entity, (state.last_report().copied(), cloth.colliders().to_vec()));
    }
}

/// Those of a cloth that took a step: its report, with the times in it, is another.
fn keep(cloths: Query<(Entity, &ClothState)>, mut given: ResMut<Given>) {
    for (entity, state) in &cloths {
        if let Some((report, colliders)) = given.before.remove(&entity)
            && report.as_ref() != state.last_report()
        {
            given.steps.entry(entity).or_default().push(colliders);
        }
    }
}

/// What a cloth was given in each of its steps since this was last called.
pub fn take_given(app: &mut App, cloth: Entity) -> Vec<Vec<Collider>> {
    app.world_mut().resource_mut::<Given>().steps.remove(&cloth).unwrap_or_default()
}

/// What a cloth was given in its last step: the entities, in order.
pub fn given_in_last_step(app: &mut App, cloth: Entity) -> Vec<Entity> {
    let last = take_given(app, cloth).pop().expect("a step");
    let mut ids = app.world_mut().query::<(Entity, &ClothId)>();
    let of = |collider: &Collider| ids.iter(app.world()).find(|(_, id)| id.0 == collider.id).expect("a collider").0;
    let mut entities: Vec<_> = last.iter().map(of).collect();
    entities.sort();
    entities
}

pub fn collider_error(app: &App, entity: Entity) -> Option<&ClothColliderError> {
    app.world().get::<ClothColliderError>(entity)
}

/// What tells an entity apart.
pub fn id(app: &App, entity: Entity) -> u64 {
    app.world().get::<ClothId>(entity).expect("an id").0
}

pub fn set_transform(app: &mut App, entity: Entity, transform: Transform) {
    *app.world_mut().get_mut(entity).expect("a transform") = transform;
}
