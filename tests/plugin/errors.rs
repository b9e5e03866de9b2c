//! Every `ClothError`: shown on the entity, gone with its cause.

use crate::common::*;
use bevy::asset::io::Reader;
use bevy::asset::{AssetLoader, LoadContext, RenderAssetUsages};
use bevy::mesh::{Indices, MeshVertexAttribute, PrimitiveTopology, VertexFormat};
use bevy::prelude::*;
use bevy_cloth::physics::{Fabric, MeshError, SettingsError, SolverKind, SolverSettings};
use bevy_cloth::plugin::*;

/// Spawns a cloth that is refused, and returns the error.
#[track_caller]
fn refused(mesh: Mesh, bundle: impl Bundle) -> (App, Entity, ClothError) {
    let mut app = app();
    let cloth = spawn(&mut app, mesh, bundle);
    run(&mut app, 3);
    let error = error(&app, cloth).expect("an error").clone();
    assert!(app.world().get::<ClothState>(cloth).is_none());
    (app, cloth, error)
}

/// Gives the cloth a good mesh and looks whether it recovers.
#[track_caller]
fn assert_recovers_with_a_good_mesh(mut app: App, cloth: Entity) {
    let good = add_mesh(&mut app, sheet());
    app.world_mut().entity_mut(cloth).insert(Mesh3d(good));
    assert_recovers(app, cloth);
}

#[track_caller]
fn assert_recovers(mut app: App, cloth: Entity) {
    run(&mut app, 2);
    assert!(error(&app, cloth).is_none(), "{:?}", error(&app, cloth));
    assert!(state(&app, cloth).last_report().is_some());
}

#[test]
fn no_mesh() {
    let mut app = app();
    let cloth = app.world_mut().spawn(ClothMesh::default()).id();
    run(&mut app, 2);
    assert!(matches!(error(&app, cloth), Some(ClothError::NoMesh)));
    assert_recovers_with_a_good_mesh(app, cloth);
}

#[test]
fn the_mesh_of_a_running_cloth_is_taken_away() {
    let mut app = app();
    let cloth = spawn(&mut app, sheet(), ());
    app.world_mut().entity_mut(cloth).remove::<Mesh3d>();
    run(&mut app, 2);
    assert!(matches!(error(&app, cloth), Some(ClothError::NoMesh)));
    assert!(app.world().get::<ClothState>(cloth).is_none());
    assert_recovers_with_a_good_mesh(app, cloth);
}

#[derive(TypePath)]
struct NoLoader;

impl AssetLoader for NoLoader {
    type Asset = Mesh;
    type Settings = ();
    type Error = std::io::Error;

    async fn load(&self, _: &mut dyn Reader, (): &(), _: &mut LoadContext<'_>) -> Result<Mesh, std::io::Error> {
        Err(std::io::Error::other("not reached: there is no such file"))
    }

    fn extensions(&self) -> &[&str] {
        &["cloth"]
    }
}

#[test]
fn the_mesh_did_not_load() {
    let mut app = app();
    app.register_asset_loader(NoLoader);
    let handle: Handle<Mesh> = app.world().resource::<AssetServer>().load("there/is/no/such.cloth");
    let cloth = app.world_mut().spawn((Mesh3d(handle), ClothMesh::default())).id();
    for _ in 0..1000 {
        app.update();
        if error(&app, cloth).is_some() {
            break;
        }
        std::thread::sleep(std::time::Duration::from_millis(2));
    }
    let error = error(&app, cloth).expect("an error").to_string();
    assert!(error.contains("such.cloth"), "{error}");
    assert_recovers_with_a_good_mesh(app, cloth);
}

#[test]
fn the_mesh_was_extracted() {
    let mut mesh = sheet();
    mesh.asset_usage = RenderAssetUsages::RENDER_WORLD;
    // As the renderer does.
    mesh.take_gpu_data().unwrap();
    let (app, cloth, error) = refused(mesh, ());
    assert!(matches!(error, ClothError::MeshExtracted), "{error}");
    assert!(error.to_string().contains("MAIN_WORLD"));
    assert_recovers_with_a_good_mesh(app, cloth);
}

#[test]
fn the_topology_is_no_surface() {
    let lines = Mesh::new(PrimitiveTopology::LineList, default())
        .with_inserted_attribute(Mesh::ATTRIBUTE_POSITION, vec![[0.0; 3]; 4]);
    let (app, cloth, error) = refused(lines, ());
    assert!(matches!(&error, ClothError::Topology { topology } if topology == "LineList"), "{error}");
    assert_recovers_with_a_good_mesh(app, cloth);
}

#[test]
fn positions_are_missing_or_of_another_format() {
    let bare = sheet().with_removed_attribute(Mesh::ATTRIBUTE_POSITION);
    let (app, cloth, error) = refused(bare, ());
    assert!(matches!(&error, ClothError::Positions { found } if found == "missing"), "{error}");
    assert_recovers_with_a_good_mesh(app, cloth);

    let four = MeshVertexAttribute::new("Vertex_Position", 0, VertexFormat::Float32x4);
    let four = Mesh::new(PrimitiveTopology::TriangleList, default()).with_inserted_attribute(four, vec![[0.0; 4]; 3]);
    let (_, _, error) = refused(four, ());
    assert!(matches!(&error, ClothError::Positions { found } if found == "Float32x4"), "{error}");
}

#[test]
fn the_geometry_is_not_cloth() {
    let empty = Mesh::new(PrimitiveTopology::TriangleList, default())
        .with_inserted_attribute(Mesh::ATTRIBUTE_POSITION, Vec::<[f32; 3]>::new());
    let mut nan = vectors(&sheet(), Mesh::ATTRIBUTE_POSITION);
    nan[7].y = f32::NAN;
    let nan = sheet().with_inserted_attribute(Mesh::ATTRIBUTE_POSITION, nan);
    let out_of_range = sheet().with_inserted_indices(Indices::U32(vec![0, 1, COUNT]));
    let cases = [
        (empty, MeshError::Empty { given: 0 }),
        (nan, MeshError::NotFinite { vertex: 7 }),
        (out_of_range, MeshError::IndexOutOfRange { triangle: 0, vertex: COUNT, count: COUNT as usize }),
    ];
    for (mesh, expected) in cases {
        let (app, cloth, error) = refused(mesh, ());
        assert!(matches!(&error, ClothError::Mesh(error) if *error == expected), "{error}");
        assert_recovers_with_a_good_mesh(app, cloth);
    }
}

#[test]
fn a_pin_is_out_of_range() {
    let (mut app, cloth, error) = refused(sheet(), ClothPins::indices([3, COUNT]));
    assert!(matches!(error, ClothError::PinIndex { vertex, count } if vertex == COUNT && count == COUNT));
    app.world_mut().entity_mut(cloth).insert(top_edge());
    assert_recovers(app, cloth);
}

#[test]
fn wrong_pins_at_run_time_leave_the_old_ones() {
    let mut app = app();
    let cloth = spawn(&mut app, sheet(), top_edge());
    app.world_mut().entity_mut(cloth).insert(ClothPins::indices([99]));
    run(&mut app, 10);
    assert!(matches!(error(&app, cloth), Some(ClothError::PinIndex { vertex: 99, .. })));
    assert_eq!(state(&app, cloth).pinned_vertices(), [0, 1, 2, 3, 4]);
    app.world_mut().entity_mut(cloth).insert(ClothPins::none());
    assert_recovers(app, cloth);
}

#[test]
fn a_pin_attribute_is_missing_or_of_another_format() {
    let weight = MeshVertexAttribute::new("Weight", 8_765_432, VertexFormat::Float32);
    let (mut app, cloth, error) = refused(sheet(), ClothPins::where_attribute(weight, 0.5));
    assert!(error.to_string().contains("`Weight`") && error.to_string().contains("none"), "{error}");
    app.world_mut().entity_mut(cloth).insert(ClothPins::none());
    assert_recovers(app, cloth);

    let uv = Mesh::ATTRIBUTE_UV_0;
    let (_, _, error) = refused(sheet(), ClothPins::where_attribute(uv, 0.5));
    assert!(matches!(&error, ClothError::PinAttribute { found, .. } if found == "Float32x2"), "{error}");
    let (_, _, error) = refused(sheet(), ClothPins::where_color(PinChannel::Red, 0.5));
    assert!(matches!(&error, ClothError::PinAttribute { attribute, .. } if attribute == "Vertex_Color"), "{error}");
}

#[test]
fn a_wrong_pin_target_is_left_out() {
    for (wrong, place) in [(COUNT, Vec3::ZERO), (7, Vec3::NAN)] {
        let mut app = app();
        let cloth = spawn(&mut app, sheet(), ClothPinTargets([(wrong, place), (24, Vec3::Z)].into()));
        run(&mut app, 2);
        match error(&app, cloth) {
            Some(ClothError::PinTargetIndex { vertex, .. } | ClothError::PinTargetNotFinite { vertex }) => {
                assert_eq!(*vertex, wrong);
            }
            other => panic!("{other:?}"),
        }
        assert_near(local(&app, cloth)[24], Vec3::Z, 1e-6);
        app.world_mut().get_mut::<ClothPinTargets>(cloth).unwrap().remove(&wrong);
        assert_recovers(app, cloth);
    }
}

#[test]
fn the_material_is_impossible() {
    let bad = ClothMaterial(Fabric { density: f32::NAN, ..Fabric::cotton() });
    let (mut app, cloth, error) = refused(sheet(), bad);
    assert!(matches!(error, ClothError::Material(_)) && error.to_string().contains("density"), "{error}");
    app.world_mut().entity_mut(cloth).insert(ClothMaterial::cotton());
    assert_recovers(app, cloth);
}

#[test]
fn an_impossible_material_at_run_time_leaves_the_old_one() {
    let mut app = app();
    let cloth = spawn(&mut app, sheet(), ClothMaterial::silk());
    app.world_mut().get_mut::<ClothMaterial>(cloth).unwrap().warp_stiffness = -1.0;
    run(&mut app, 2);
    assert!(error(&app, cloth).unwrap().to_string().contains("warp_stiffness"));
    assert_eq!(*state(&app, cloth).cloth().fabric(), Fabric::silk());
    app.world_mut().entity_mut(cloth).insert(ClothMaterial::silk());
    assert_recovers(app, cloth);
}

#[test]
fn the_scale_is_zero_from_the_start() {
    let (mut app, cloth, error) = refused(sheet(), Transform::from_scale(Vec3::ZERO));
    assert!(matches!(error, ClothError::Transform));
    *app.world_mut().get_mut::<Transform>(cloth).unwrap() = Transform::default();
    app.update();
    assert_recovers(app, cloth);
}

#[test]
fn a_rejected_step_is_told_until_one_succeeds() {
    let mut app = app();
    let cloth = spawn(&mut app, sheet(), top_edge());
    run(&mut app, 3);
    app.insert_resource(ClothGravity(Vec3::new(0.0, f32::INFINITY, 0.0)));
    run(&mut app, 2);
    assert!(matches!(error(&app, cloth), Some(ClothError::Diverged { .. })), "{:?}", error(&app, cloth));
    assert!(local(&app, cloth).iter().all(|p| p.is_finite()));
    app.insert_resource(ClothGravity::default());
    assert_recovers(app, cloth);
}

#[test]
fn a_description_that_cannot_be_leaves_the_cloth_running() {
    let mut app = app();
    let cloth = spawn(&mut app, sheet(), ClothPins::indices([0]));
    run(&mut app, 10);
    let before = local(&app, cloth)[24];
    app.world_mut().get_mut::<ClothMesh>(cloth).unwrap().weld_distance = Some(10.0);
    run(&mut app, 2);
    assert!(matches!(error(&app, cloth), Some(ClothError::Mesh(MeshError::Empty { .. }))), "{:?}", error(&app, cloth));
    assert_ne!(local(&app, cloth)[24], before);
    app.world_mut().get_mut::<ClothMesh>(cloth).unwrap().weld_distance = None;
    run(&mut app, 1);
    assert_recovers(app, cloth);
}

#[test]
fn the_description_is_not_a_number() {
    let mut app = app();
    let cloth = spawn(&mut app, sheet(), ClothPins::indices([0]));
    for (wrong, expected) in [
        (ClothMesh { weld_distance: Some(-1.0), ..default() }, "weld_distance"),
        (ClothMesh { warp_angle: f32::NAN, ..default() }, "warp_angle"),
    ] {
        // Told while it runs as well as from the start.
        let late = spawn(&mut app, sheet(), ());
        app.world_mut().entity_mut(late).remove::<(ClothMesh, Mesh3d)>();
        let mesh = add_mesh(&mut app, sheet());
        app.world_mut().entity_mut(late).insert((wrong, Mesh3d(mesh)));
        app.world_mut().entity_mut(cloth).insert(wrong);
        run(&mut app, 2);
        for cloth in [cloth, late] {
            assert!(error(&app, cloth).expect("an error").to_string().contains(expected), "{expected}");
        }
    }
    app.world_mut().entity_mut(cloth).insert(ClothMesh::default());
    assert_recovers(app, cloth);
}

#[test]
fn solver_settings_that_cannot_be_used() {
    let with_tolerance = |tolerance| {
        ClothSolver(SolverSettings { kind: SolverKind::conjugate_gradient(tolerance), ..Default::default() })
    };
    let (mut app, cloth, error_shown) = refused(sheet(), with_tolerance(f32::NAN));
    assert!(matches!(error_shown, ClothError::Solver(SettingsError::Tolerance(_))), "{error_shown}");
    app.world_mut().entity_mut(cloth).insert(with_tolerance(0.1));
    assert_recovers(app, cloth);

    // A running cloth goes on with the settings it had.
    let mut app = self::app();
    let cloth = spawn(&mut app, sheet(), with_tolerance(0.1));
    run(&mut app, 3);
    app.world_mut().get_mut::<ClothSolver>(cloth).unwrap().substeps = 0;
    run(&mut app, 2);
    assert!(matches!(error(&app, cloth), Some(ClothError::Solver(SettingsError::NoSubsteps))));
    assert_eq!(state(&app, cloth).cloth().settings().substeps, 1);
    app.world_mut().get_mut::<ClothSolver>(cloth).unwrap().substeps = 2;
    assert_recovers(app, cloth);
}
