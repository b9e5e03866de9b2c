//! A glTF file with a mesh that becomes cloth.

use crate::{cli::Cli, framing};
use bevy::{
    asset::{LoadState, RecursiveDependencyLoadState},
    prelude::*,
    world_serialization::{WorldInstance, WorldInstanceSpawner},
};
use bevy_cloth::{physics::Fabric, prelude::*};
use example_common::scene::SceneState;
use std::path::{Path, PathBuf};

/// What to load and how to turn it into cloth.
#[derive(Resource, Clone)]
pub struct Model {
    /// Absolute, or relative to the assets.
    pub path: PathBuf,
    /// The node whose mesh becomes cloth.
    pub node: Option<String>,
    /// Nodes to leave out.
    pub without: Vec<String>,
    /// Share of the cloth's height that is held from the top, where the mesh does not say itself.
    pub pin_top: f32,
    /// Name or number of the animation; `None` chooses one.
    pub animation: Option<String>,
    pub fabric: Fabric,
    pub transform: Transform,
    /// See [`ClothMesh::rest_flat`].
    pub rest_flat: bool,
    /// Stage and camera are to be fitted to the model.
    pub framed: bool,
}

impl Model {
    pub fn new(path: impl Into<PathBuf>, fabric: Fabric) -> Self {
        Self {
            path: path.into(),
            node: None,
            without: Vec::new(),
            pin_top: 0.15,
            animation: None,
            fabric,
            transform: Transform::IDENTITY,
            rest_flat: false,
            framed: true,
        }
    }

    /// The file named on the command line; an error if there is none.
    pub fn from_cli(cli: &Cli, path: &Path) -> Result<Self, String> {
        let path = path.canonicalize().map_err(|error| format!("cannot read {}: {error}", path.display()))?;
        Ok(Self {
            node: cli.node.clone(),
            without: cli.without.clone(),
            pin_top: cli.pin_top,
            animation: cli.animation.clone(),
            ..Self::new(path, cli.fabric())
        })
    }
}

/// Loads the model, spawns it, plays its animation and turns its mesh into cloth.
pub struct ModelPlugin(pub Model);

impl Plugin for ModelPlugin {
    fn build(&self, app: &mut App) {
        app.insert_resource(self.0.clone()).add_systems(Startup, start).add_systems(Update, advance);
    }
}

/// How far the model has come.
#[derive(Resource, Clone)]
enum Progress {
    Loading(Handle<Gltf>),
    Spawning {
        root: Entity,
        file: Handle<Gltf>,
    },
    /// Waits until the first pose of the animation has reached the transforms.
    Posing {
        root: Entity,
        updates_left: u32,
    },
    Done,
}

fn start(world: &mut World) {
    let path = world.resource::<Model>().path.clone();
    let file = world.resource::<AssetServer>().load(path);
    world.insert_resource(Progress::Loading(file));
    if world.resource::<Model>().framed {
        framing::spawn_camera(world);
    }
}

fn advance(world: &mut World) {
    let model = world.resource::<Model>().clone();
    let next = match world.resource::<Progress>().clone() {
        Progress::Loading(file) => load(world, &model, file),
        Progress::Spawning { root, file } => pose(world, &model, root, file),
        Progress::Posing { root, updates_left: 0 } => make_cloth(world, &model, root),
        Progress::Posing { root, updates_left } => Ok(Progress::Posing { root, updates_left: updates_left - 1 }),
        Progress::Done => return,
    };
    let next = next.unwrap_or_else(|problem| {
        world.insert_resource(SceneState::Failed(problem));
        Progress::Done
    });
    world.insert_resource(next);
}

fn load(world: &mut World, model: &Model, file: Handle<Gltf>) -> Result<Progress, String> {
    match world.resource::<AssetServer>().get_load_states(&file) {
        Some((LoadState::Failed(error), _, _)) | Some((_, _, RecursiveDependencyLoadState::Failed(error))) => {
            // What follows is a backtrace.
            let reason = error.to_string().lines().next().unwrap_or_default().to_string();
            Err(format!("cannot load {}: {reason}", model.path.display()))
        }
        Some((_, _, RecursiveDependencyLoadState::Loaded)) => {
            let gltf = world.resource::<Assets<Gltf>>().get(&file);
            let scene = gltf.and_then(|gltf| gltf.default_scene.clone().or_else(|| gltf.scenes.first().cloned()));
            let scene = scene.ok_or_else(|| format!("{} has no scene", model.path.display()))?;
            let root = world.spawn((WorldAssetRoot(scene), model.transform)).id();
            Ok(Progress::Spawning { root, file })
        }
        _ => Ok(Progress::Loading(file)),
    }
}

fn pose(world: &mut World, model: &Model, root: Entity, file: Handle<Gltf>) -> Result<Progress, String> {
    let spawner = world.resource::<WorldInstanceSpawner>();
    if !world.get::<WorldInstance>(root).is_some_and(|instance| spawner.instance_is_ready(**instance)) {
        return Ok(Progress::Spawning { root, file });
    }
    // Cameras of the file would compete with ours.
    for entity in descendants(world, root) {
        world.entity_mut(entity).remove::<Camera>();
    }
    leave_out(world, model, root)?;
    animate(world, model, root, &file)?;
    Ok(Progress::Posing { root, updates_left: 2 })
}

fn leave_out(world: &mut World, model: &Model, root: Entity) -> Result<(), String> {
    for name in &model.without {
        let called = |entity: &Entity| world.get::<Name>(*entity).is_some_and(|it| it.as_str() == name);
        let node = descendants(world, root).into_iter().find(called);
        let node = node.ok_or_else(|| format!("{} has no node {name:?} to leave out", model.path.display()))?;
        world.entity_mut(node).despawn();
    }
    Ok(())
}

/// Plays the animation asked for, or one that suits.
fn animate(world: &mut World, model: &Model, root: Entity, file: &Handle<Gltf>) -> Result<(), String> {
    let gltf = world.resource::<Assets<Gltf>>().get(file).ok_or("the file was unloaded")?;
    let mut names: Vec<&str> = gltf.named_animations.keys().map(|name| &**name).collect();
    names.sort_unstable();
    let containing = |word: &str| names.iter().find(|name| name.to_lowercase().contains(word)).copied();
    let clip = match model.animation.as_deref() {
        Some("none") => None,
        Some(wanted) => {
            let by_number = || wanted.parse::<usize>().ok().and_then(|number| gltf.animations.get(number));
            let clip = gltf.named_animations.get(wanted).or_else(by_number);
            Some(clip.ok_or_else(|| match names.as_slice() {
                [] => format!("{} has no animation", model.path.display()),
                names => format!("there is no animation {wanted:?}; choose one of {}", names.join(", ")),
            })?)
        }
        None => containing("walk")
            .or_else(|| containing("idle"))
            .and_then(|name| gltf.named_animations.get(name))
            .or(gltf.animations.first()),
    };
    let Some(clip) = clip.cloned() else { return Ok(()) };
    let (graph, node) = AnimationGraph::from_clip(clip);
    let graph = AnimationGraphHandle(world.resource_mut::<Assets<AnimationGraph>>().add(graph));
    for entity in descendants(world, root) {
        if let Some(mut player) = world.get_mut::<AnimationPlayer>(entity) {
            player.play(node).repeat();
            world.entity_mut(entity).insert(graph.clone());
        }
    }
    Ok(())
}

fn make_cloth(world: &mut World, model: &Model, root: Entity) -> Result<Progress, String> {
    let meshes = find_meshes(world, model, root)?;
    if model.framed {
        framing::frame(world, root, &meshes);
    }
    let mut nodes: Vec<Entity> = meshes.iter().filter_map(|&mesh| Some(world.get::<ChildOf>(mesh)?.parent())).collect();
    nodes.dedup();
    for node in nodes {
        // All primitives of a node are one cloth, in the order of the children.
        let primitives: Vec<Entity> = world.get::<Children>(node).into_iter().flatten().copied().collect();
        let weighted = primitives.iter().any(|&primitive| has_pin_weights(world, primitive));
        let pins = if weighted { ClothPins::default() } else { top_edge(world, &primitives, model.pin_top) };
        primitives.into_iter().for_each(|primitive| show_both_sides(world, primitive));
        world.entity_mut(node).insert((
            ClothMesh { rest_flat: model.rest_flat, ..default() },
            ClothMaterial(model.fabric),
            pins,
        ));
    }
    Ok(Progress::Done)
}

/// The meshes of the node asked for. A node's primitives are entities below the one that carries its name.
fn find_meshes(world: &World, model: &Model, root: Entity) -> Result<Vec<Entity>, String> {
    let meshes: Vec<(Entity, &str)> = descendants(world, root)
        .into_iter()
        .filter(|&entity| world.entity(entity).contains::<Mesh3d>())
        .map(|entity| {
            let node = world.get::<ChildOf>(entity).and_then(|child| world.get::<Name>(child.parent()));
            (entity, node.map_or("", |name| name.as_str()))
        })
        .collect();
    let mut names: Vec<&str> = meshes.iter().map(|(_, name)| *name).collect();
    names.sort_unstable();
    names.dedup();
    let path = model.path.display();

    let chosen: Vec<Entity> = match &model.node {
        Some(node) => meshes.iter().filter(|(_, name)| name == node).map(|(entity, _)| *entity).collect(),
        None if names.len() == 1 => meshes.iter().map(|(entity, _)| *entity).collect(),
        None => meshes.iter().map(|(entity, _)| *entity).filter(|&entity| has_pin_weights(world, entity)).collect(),
    };
    match (&model.node, names.is_empty(), chosen.is_empty()) {
        (_, true, _) => Err(format!("{path} has no mesh")),
        (Some(node), _, true) => Err(format!("{path} has no node {node:?} with a mesh; it has {}", names.join(", "))),
        (None, _, true) => Err(format!("choose the cloth of {path} with --node, one of {}", names.join(", "))),
        _ => Ok(chosen),
    }
}

fn has_pin_weights(world: &World, entity: Entity) -> bool {
    mesh_of(world, entity).is_some_and(|mesh| mesh.contains_attribute(ATTRIBUTE_CLOTH_PIN))
}

/// Holds the vertices within `share` of the cloth's height from its top, as it hangs in the world.
fn top_edge(world: &World, meshes: &[Entity], share: f32) -> ClothPins {
    let positions = meshes.iter().flat_map(|&mesh| framing::world_positions(world, mesh));
    let heights = positions.map(|position| position.y);
    let heights: Vec<f32> = heights.collect();
    let top = heights.iter().copied().fold(f32::MIN, f32::max);
    let bottom = heights.iter().copied().fold(f32::MAX, f32::min);
    let limit = top - share * (top - bottom);
    ClothPins::indices((0..).zip(heights).filter(|(_, height)| *height >= limit).map(|(vertex, _)| vertex))
}

/// Cloth is seen from behind too; many models cull their back faces.
fn show_both_sides(world: &mut World, entity: Entity) {
    let Some(look) = world.get::<MeshMaterial3d<StandardMaterial>>(entity).cloned() else { return };
    let mut materials = world.resource_mut::<Assets<StandardMaterial>>();
    let Some(material) = materials.get(&look.0).filter(|material| !material.double_sided).cloned() else { return };
    let both = materials.add(StandardMaterial { double_sided: true, cull_mode: None, ..material });
    world.entity_mut(entity).insert(MeshMaterial3d(both));
}

/// The mesh asset of an entity.
pub fn mesh_of(world: &World, entity: Entity) -> Option<&Mesh> {
    world.resource::<Assets<Mesh>>().get(&world.get::<Mesh3d>(entity)?.0)
}

/// Everything below `root`.
pub fn descendants(world: &World, root: Entity) -> Vec<Entity> {
    let children = |entity| world.get::<Children>(entity).into_iter().flat_map(|children| children.iter());
    let mut found: Vec<Entity> = children(root).collect();
    let mut next = 0;
    while let Some(&entity) = found.get(next) {
        found.extend(children(entity));
        next += 1;
    }
    found
}
