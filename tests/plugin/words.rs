//! What is said, once, of what is legal and surely not meant.

use std::sync::{Mutex, Once};

use crate::common::*;
use bevy::mesh::skinning::SkinnedMesh;
use bevy::mesh::{Indices, MeshVertexAttribute, PrimitiveTopology, VertexAttributeValues, VertexFormat};
use bevy::prelude::*;
use bevy_cloth::physics::Fabric;
use bevy_cloth::plugin::*;
use tracing::field::{Field, Visit};
use tracing::{Event, Level, Metadata, Subscriber, span};

static LOG: Mutex<Vec<(Level, String)>> = Mutex::new(Vec::new());

/// Keeps what is logged.
struct Keeper;

impl Subscriber for Keeper {
    fn enabled(&self, _: &Metadata) -> bool {
        true
    }

    fn new_span(&self, _: &span::Attributes) -> span::Id {
        span::Id::from_u64(1)
    }

    fn record(&self, _: &span::Id, _: &span::Record) {}

    fn record_follows_from(&self, _: &span::Id, _: &span::Id) {}

    fn event(&self, event: &Event) {
        struct Message(String);
        impl Visit for Message {
            fn record_debug(&mut self, field: &Field, value: &dyn std::fmt::Debug) {
                if field.name() == "message" {
                    self.0 = format!("{value:?}");
                }
            }
        }
        let mut message = Message(String::new());
        event.record(&mut message);
        if message.0.starts_with("cloth ") {
            LOG.lock().unwrap().push((*event.metadata().level(), message.0));
        }
    }

    fn enter(&self, _: &span::Id) {}

    fn exit(&self, _: &span::Id) {}
}

fn listen() {
    static ONCE: Once = Once::new();
    ONCE.call_once(|| tracing::subscriber::set_global_default(Keeper).expect("nobody else listens"));
}

/// What was said of the cloth of this name, warnings and errors.
fn said(name: &str) -> Vec<String> {
    let log = LOG.lock().unwrap();
    let of_it = log.iter().filter(|(level, text)| *level <= Level::WARN && text.contains(&format!("cloth {name}")));
    of_it.map(|(_, text)| text.clone()).collect()
}

/// A cloth of this name that runs for so many frames.
fn watched(name: &'static str, mesh: Mesh, frames: usize, bundle: impl Bundle) -> (App, Entity) {
    listen();
    let mut app = app();
    let cloth = spawn(&mut app, mesh, (Name::new(name), bundle));
    run(&mut app, frames);
    (app, cloth)
}

/// Said once, with these words in it.
#[track_caller]
fn assert_said_once(name: &str, words: &[&str]) {
    let said = said(name);
    assert_eq!(said.len(), 1, "{said:?}");
    for word in words {
        assert!(said[0].contains(word), "{} does not say {word}", said[0]);
    }
}

#[test]
fn a_good_cloth_is_passed_over_in_silence() {
    _ = watched("Good", sheet(), 100, top_edge());
    _ = watched("Good", sheet(), 10, ());
    _ = watched("Good", sheet(), 10, ClothPins::none());
    assert_eq!(said("Good"), [""; 0]);
}

#[test]
fn pins_that_hold_nothing() {
    _ = watched("None", sheet(), 10, ClothPins::where_position(|p| p.y > 0.5));
    assert_said_once(
        "None",
        &["holds none of 25 vertices", "x 0..1, y -1..0, z 0..0", "before the entity's transform"],
    );
    // At run time, too.
    let (mut app, cloth) = watched("Late", sheet(), 10, top_edge());
    app.world_mut().entity_mut(cloth).insert(ClothPins::in_box(Vec3::splat(5.0), Vec3::splat(6.0)));
    run(&mut app, 10);
    assert_said_once("Late", &["holds none of 25 vertices"]);
}

#[test]
fn pieces_without_pins() {
    let mut two = sheet();
    two.merge(&sheet().translated_by(Vec3::X * 5.0)).unwrap();
    _ = watched("Pieces", two.clone(), 10, ClothPins::indices([0]));
    assert_said_once("Pieces", &["1 of the 2 separate pieces"]);
    _ = watched("Both", two, 10, top_edge());
    assert_eq!(said("Both"), [""; 0]);
}

#[test]
fn densities_and_sizes_that_no_cloth_has() {
    let heavy = ClothMaterial(Fabric { density: 150.0, ..Fabric::cotton() });
    _ = watched("Heavy", sheet(), 10, (top_edge(), heavy));
    assert_said_once("Heavy", &["150 kg/m²", "g/m²?"]);
    _ = watched("Large", sheet().scaled_by(Vec3::splat(100.0)), 10, top_edge());
    assert_said_once("Large", &["100.000 m", "centimeters"]);
    _ = watched("Small", sheet().scaled_by(Vec3::splat(0.005)), 80, ());
    assert_said_once("Small", &["0.005 m", "small"]);
    _ = watched(
        "Scaled",
        sheet().scaled_by(Vec3::splat(100.0)),
        80,
        (top_edge(), Transform::from_scale(Vec3::splat(0.01))),
    );
    assert_eq!(said("Scaled"), [""; 0]);
}

#[test]
fn what_grows_out_of_nothing_is_no_error() {
    listen();
    let mut app = app();
    let cloth = spawn(&mut app, sheet(), (Name::new("Grown"), top_edge(), Transform::from_scale(Vec3::ZERO)));
    run(&mut app, 2);
    assert!(matches!(error(&app, cloth), Some(ClothError::Transform)));
    for frame in 1..=100 {
        set_transform(&mut app, cloth, Transform::from_scale(Vec3::splat(0.01 * frame as f32)));
        app.update();
    }
    assert!(error(&app, cloth).is_none());
    assert!(state(&app, cloth).cloth().stretch().max < 0.05);
    assert_said_once("Grown", &["waits until it is usable"]);
    let errors =
        LOG.lock().unwrap().iter().filter(|(level, text)| *level == Level::ERROR && text.contains("Grown")).count();
    assert_eq!(errors, 0);
}

#[test]
fn a_skinned_mesh() {
    _ = watched("Skinned", sheet(), 10, (top_edge(), SkinnedMesh::default()));
    assert_said_once("Skinned", &["was skinned", "not the bones", "ClothPinTargets"]);
}

#[test]
fn a_vertex_in_the_middle_of_an_edge() {
    let positions = [[0.0, 0.0], [2.0, 0.0], [1.0, 1.0], [1.0, 0.0], [1.0, -1.0]].map(|[x, y]| [x, y, 0.0_f32]);
    let open = Mesh::new(PrimitiveTopology::TriangleList, default())
        .with_inserted_attribute(Mesh::ATTRIBUTE_POSITION, positions.to_vec())
        .with_inserted_indices(Indices::U32(vec![0, 1, 2, 0, 4, 3, 3, 4, 1]));
    _ = watched("Open", open, 10, ClothPins::indices([0]));
    assert_said_once("Open", &["1 vertices lie in the middle of another triangle's edge", "split"]);
}

/// As a glTF file has a mesh of two materials: two meshes of one node.
#[test]
fn parts_of_one_mesh_beside_each_other() {
    listen();
    let mut app = app();
    let half = |side: f32| sheet().translated_by(Vec3::X * side);
    let parts = [half(0.0), half(1.0), half(5.0)].map(|mesh| Mesh3d(add_mesh(&mut app, mesh)));
    let node = app.world_mut().spawn(Transform::from_xyz(1.0, 2.0, 3.0)).id();
    for (part, name) in parts.into_iter().zip(["Red", "Blue", "Apart"]) {
        app.world_mut().spawn((part, ClothMesh::default(), top_edge(), Name::new(name), ChildOf(node)));
    }
    run(&mut app, 10);
    // By one of the two, which names the other.
    assert_eq!(said("Red"), said("Blue"));
    assert_said_once("Blue", &["5 vertices of its border", "put `ClothMesh` on their parent"]);
    assert_eq!(said("Apart"), [""; 0]);
}

#[test]
fn predicates_that_a_saved_scene_has_lost() {
    listen();
    let saved = ClothPins::indices([0]).or(top_edge()).to_dynamic();
    let loaded = ClothPins::from_reflect(&*saved).unwrap();
    _ = watched("Loaded", sheet(), 10, loaded);
    assert_said_once("Loaded", &["lost 1 predicates", "in_box"]);
}

#[test]
fn a_mesh_that_never_comes() {
    listen();
    let mut app = app();
    let gone = add_mesh(&mut app, sheet());
    app.world_mut().resource_mut::<Assets<Mesh>>().remove(&gone);
    let cloths = [Mesh3d::default(), Mesh3d(gone.clone())]
        .map(|mesh3d| app.world_mut().spawn((mesh3d, ClothMesh::default(), Name::new("Gone"))).id());
    run(&mut app, 100);
    for cloth in cloths {
        assert!(matches!(error(&app, cloth), Some(ClothError::MeshGone)), "{:?}", error(&app, cloth));
    }
    assert_eq!(said("Gone").len(), 2, "{:?}", said("Gone"));
    // It comes after all.
    app.world_mut().resource_mut::<Assets<Mesh>>().insert(gone.id(), sheet()).unwrap();
    run(&mut app, 3);
    assert!(error(&app, cloths[1]).is_none());
    assert!(state(&app, cloths[1]).last_report().is_some());
}

#[test]
fn an_own_mesh_that_was_removed_is_made_again() {
    let (mut app, cloth) = watched("Removed", sheet(), 30, ClothPins::indices([0]));
    let own = state(&app, cloth).own_mesh().clone();
    app.world_mut().resource_mut::<Assets<Mesh>>().remove(&own);
    let before = state(&app, cloth).cloth().positions()[24];
    run(&mut app, 2);
    assert_ne!(state(&app, cloth).own_mesh(), &own);
    assert_eq!(app.world().get::<Mesh3d>(cloth).unwrap().0, *state(&app, cloth).own_mesh());
    assert!(state(&app, cloth).cloth().positions()[24].distance(before) < 0.2, "the motion goes on");
    assert_near(world(&app, cloth)[24], state(&app, cloth).cloth().positions()[24].as_vec3(), 1e-5);
    assert!(error(&app, cloth).is_none());

    // With the source gone, too, there is nothing to make it of.
    let [own, source] = [state(&app, cloth).own_mesh().clone(), state(&app, cloth).source_mesh().clone()];
    let mut meshes = app.world_mut().resource_mut::<Assets<Mesh>>();
    meshes.remove(&own);
    meshes.remove(&source);
    run(&mut app, 3);
    assert!(matches!(error(&app, cloth), Some(ClothError::OwnMeshGone)), "{:?}", error(&app, cloth));
    app.world_mut().resource_mut::<Assets<Mesh>>().insert(source.id(), sheet()).unwrap();
    run(&mut app, 3);
    assert!(error(&app, cloth).is_none());
}

#[test]
fn the_mesh_of_a_gltf_scene_is_further_down() {
    listen();
    let mut app = app();
    let mesh3d = Mesh3d(add_mesh(&mut app, sheet()));
    let node = children![(Name::new("Cape"), Transform::default(), children![(mesh3d, Name::new("Cape.0"))])];
    let scene = app.world_mut().spawn((ClothMesh::default(), Name::new("Scene"), node)).id();
    run(&mut app, 3);
    assert!(matches!(error(&app, scene), Some(ClothError::MeshBelow { node }) if node == "Cape"));
    assert_said_once("Scene", &["put `ClothMesh` on Cape"]);
}

/// glTF has vertex colors of 8 and 16 bits, too.
#[test]
fn colors_of_few_bits_pin_as_well() {
    let red = |vertex: u32| if vertex <= CELLS { u8::MAX } else { 0 };
    let eight: Vec<[u8; 4]> = (0..COUNT).map(|vertex| [red(vertex), 0, 0, u8::MAX]).collect();
    let sixteen: Vec<[u16; 4]> = eight.iter().map(|color| color.map(|channel| 257 * u16::from(channel))).collect();
    let id = Mesh::ATTRIBUTE_COLOR;
    let cases = [
        (VertexFormat::Unorm8x4, VertexAttributeValues::Unorm8x4(eight)),
        (VertexFormat::Unorm16x4, VertexAttributeValues::Unorm16x4(sixteen)),
    ];
    for (format, values) in cases {
        let attribute = MeshVertexAttribute { id: id.id, name: id.name, format };
        let colored = sheet().with_inserted_attribute(attribute, values);
        let mut app = app();
        let cloth = spawn(&mut app, colored, ClothPins::where_color(PinChannel::Red, 0.5));
        assert_eq!(state(&app, cloth).pinned_vertices(), [0, 1, 2, 3, 4], "{format:?}");
    }
}

/// Stands for Bevy's component of the same path, which is there with its feature `morph`.
#[derive(Component, Reflect)]
#[type_path = "bevy_mesh::morph"]
#[reflect(Component)]
struct MeshMorphWeights;

/// Bevy #23811: under the limits of WebGL 2, weights without targets end the opaque phase.
#[test]
fn morph_weights_go_with_the_targets() {
    let mut app = app();
    app.register_type::<MeshMorphWeights>();
    let cloth = spawn(&mut app, sheet(), MeshMorphWeights);
    run(&mut app, 2);
    assert!(state(&app, cloth).last_report().is_some());
    assert!(app.world().get::<MeshMorphWeights>(cloth).is_none());
}
