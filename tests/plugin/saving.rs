//! Worlds saved by reflection, and loaded again.

use bevy::asset::{AssetServer, uuid_handle};
use bevy::camera::visibility::VisibilityClass;
use bevy::ecs::entity::EntityHashMap;
use bevy::prelude::*;
use bevy::reflect::serde::{ReflectDeserializer, ReflectSerializer};
use bevy::reflect::{FromReflect, TypeRegistry};
use bevy::world_serialization::DynamicWorldBuilder;
use bevy::world_serialization::serde::WorldDeserializer;
use bevy_cloth::parry3d::shape::SharedShape;
use bevy_cloth::plugin::*;
use serde::de::DeserializeSeed;

use crate::common::*;

fn through_text(registry: &TypeRegistry, collider: &ClothCollider) -> ClothCollider {
    let text = ron::to_string(&ReflectSerializer::new(collider, registry)).unwrap();
    let mut reader = ron::Deserializer::from_str(&text).unwrap();
    let back = ReflectDeserializer::new(registry).deserialize(&mut reader).unwrap();
    ClothCollider::from_reflect(&*back).unwrap_or_else(|| panic!("{text}"))
}

fn every_shape() -> Vec<ClothCollider> {
    let ball = Sphere::new(0.5).mesh().uv(12, 8);
    let parts = [
        (Vec3::X, Quat::from_rotation_z(0.3), ClothCollider::cuboid(0.1, 0.2, 0.3)),
        (Vec3::ZERO, Quat::IDENTITY, ClothCollider::sphere(0.2)),
    ];
    vec![
        ClothCollider::sphere(0.3).with_friction(0.25),
        ClothCollider::capsule_between(Vec3::X, Vec3::new(0.1, 0.2, 0.3), 0.1).with_teleport_speed(7.0),
        ClothCollider::cuboid(0.1, 0.2, 0.3),
        ClothCollider::cylinder(0.2, 0.7),
        ClothCollider::cone(0.2, 0.7),
        ClothCollider::half_space(Dir3::X),
        ClothCollider::hull_of_mesh(&ball).unwrap(),
        ClothCollider::from_mesh(&ball).unwrap(),
        ClothCollider::heightfield(&[vec![0.0, 0.1, 0.2], vec![0.3, 0.4, 0.5]], Vec3::new(4.0, 3.0, 2.0)).unwrap(),
        ClothCollider::compound(parts).unwrap(),
    ]
}

#[test]
fn every_shape_comes_back_through_reflection() {
    let app = app();
    let registry = app.world().resource::<AppTypeRegistry>().read();
    for collider in every_shape() {
        let back = through_text(&registry, &collider);
        assert_eq!(back, collider);
        let boxes = [&back, &collider].map(|collider| collider.shape().compute_local_aabb());
        assert_eq!(boxes[0], boxes[1]);
        assert_eq!(back.shape().shape_type(), collider.shape().shape_type());
        // A shape of parry is described as the constructor does.
        let same = ClothCollider::new(collider.shape().clone());
        assert_eq!(same.shape().compute_local_aabb(), boxes[0]);
        assert_eq!(core::mem::discriminant(same.description()), core::mem::discriminant(collider.description()));
        assert_eq!(ron::from_str::<ClothCollider>(&ron::to_string(&collider).unwrap()).unwrap(), collider);
    }
}

#[test]
fn a_collider_put_in_by_reflection_touches_cloth() {
    let mut app = app_with_notes();
    let cloth = spawn(&mut app, sheet(), top_edge());
    let entity = app.world_mut().spawn_empty().id();
    let registry = app.world().resource::<AppTypeRegistry>().clone();
    let registry = registry.read();
    let reflected = registry.get_type_data::<ReflectComponent>(core::any::TypeId::of::<ClothCollider>()).unwrap();
    let ball = ClothCollider::sphere(0.4);
    let mut dynamic = bevy::reflect::structs::DynamicStruct::default();
    dynamic.set_represented_type(Some(<ClothCollider as bevy::reflect::Typed>::type_info()));
    dynamic.insert_boxed("shape", ball.description().to_dynamic());
    reflected.insert(&mut app.world_mut().entity_mut(entity), &dynamic, &registry);
    assert_eq!(*app.world().get::<ClothCollider>(entity).unwrap(), ball);
    run(&mut app, 2);
    assert_eq!(given_in_last_step(&mut app, cloth), [entity]);
    // An inspector makes it another size.
    let mut edited = reflected.reflect_mut(app.world_mut().entity_mut(entity)).unwrap();
    *edited.path_mut::<f32>(".shape.radius").unwrap() = 0.2;
    run(&mut app, 2);
    let extents = app.world().get::<ClothCollider>(entity).unwrap().shape().compute_local_aabb().extents();
    assert_eq!(extents.x, 0.4);
    let mut edited = reflected.reflect_mut(app.world_mut().entity_mut(entity)).unwrap();
    *edited.path_mut::<f32>(".shape.radius").unwrap() = -1.0;
    run(&mut app, 2);
    assert!(matches!(collider_error(&app, entity), Some(ClothColliderError::Shape)));
}

#[test]
fn a_shape_that_has_no_description_says_so_when_it_is_loaded() {
    let mut app = app();
    let round = ClothCollider::new(SharedShape::round_cuboid(0.1, 0.1, 0.1, 0.02));
    assert_eq!(*round.description(), ClothShape::Undescribed);
    let registry = app.world().resource::<AppTypeRegistry>().clone();
    let back = through_text(&registry.read(), &round);
    spawn(&mut app, sheet(), top_edge());
    let lost = app.world_mut().spawn(back.clone()).id();
    let mesh = Mesh3d(add_mesh(&mut app, Sphere::new(0.5).into()));
    let made_again = app.world_mut().spawn((back, mesh, ClothMeshCollider::default())).id();
    run(&mut app, 3);
    let told = collider_error(&app, lost).expect("an error").to_string();
    assert!(told.contains("not saved"), "{told}");
    assert!(collider_error(&app, made_again).is_none());
    let extents = app.world().get::<ClothCollider>(made_again).unwrap().shape().compute_local_aabb().extents();
    assert!((extents.x - 1.0).abs() < 0.05);
}

#[test]
fn a_mesh_in_a_compound_is_refused() {
    let mesh = ClothCollider::from_mesh(&Sphere::new(0.5).into()).unwrap();
    let error = ClothCollider::compound([(Vec3::ZERO, Quat::IDENTITY, mesh)]).unwrap_err();
    assert_eq!(error, ClothShapeError::Part { part: 0 });
}

/// What is built in code, under a name that stays the same.
const SHEET: Handle<Mesh> = uuid_handle!("3d9a7c1e-6c1b-4c0e-9f63-2a5d0f3c8b11");

/// What is to be saved.
#[derive(Component, Clone, Copy, Default, Reflect)]
#[reflect(Component, Default)]
struct Saved;

fn app_with_sheet() -> App {
    let mut app = app();
    // Bevy registers its own where its feature `reflect_auto_register` is on.
    app.register_type::<Saved>().register_type::<Mesh3d>().register_type::<Transform>();
    app.world_mut().resource_mut::<Assets<Mesh>>().insert(&SHEET, sheet()).unwrap();
    app
}

/// All that is marked, as Bevy saves it.
fn save(app: &mut App) -> String {
    let mut states = app.world_mut().query::<(Entity, &ClothState)>();
    let snapshots: Vec<_> = states.iter(app.world()).map(|(entity, state)| (entity, state.snapshot())).collect();
    for (entity, snapshot) in snapshots {
        app.world_mut().entity_mut(entity).insert(snapshot);
    }
    let mut saved = app.world_mut().query_filtered::<Entity, With<Saved>>();
    let saved: Vec<_> = saved.iter(app.world()).collect();
    let registry = app.world().resource::<AppTypeRegistry>().read();
    let world = DynamicWorldBuilder::from_world(app.world(), &registry)
        // Bevy computes it, and text cannot hold it.
        .deny_component::<VisibilityClass>()
        .extract_entities(saved.into_iter())
        .build();
    world.serialize(&registry).unwrap()
}

fn load(app: &mut App, file: &str) -> EntityHashMap<Entity> {
    let registry = app.world().resource::<AppTypeRegistry>().clone();
    let mut server = app.world().resource::<AssetServer>().clone();
    let mut reader = ron::Deserializer::from_str(file).unwrap();
    let world = WorldDeserializer { type_registry: &registry.read(), load_from_path: &mut server };
    let world = world.deserialize(&mut reader).unwrap();
    let mut map = EntityHashMap::default();
    world.write_to_world(app.world_mut(), &mut map).unwrap();
    map
}

#[test]
fn a_world_with_cloth_and_colliders_goes_on_after_loading() {
    let mut app = app_with_sheet();
    let turned = |angle| Transform::from_rotation(Quat::from_rotation_y(angle));
    // It pushes the sheet out of the plane that it hangs in.
    let place = turned(0.45).transform_point(Vec3::new(0.5, -0.6, -0.25));
    let ball = (ClothCollider::sphere(0.3), Transform::from_translation(place), Saved);
    let ball = app.world_mut().spawn(ball).id();
    let far = Transform::from_xyz(0.0, 0.0, -50.0);
    let wall = app.world_mut().spawn((Mesh3d(SHEET), ClothMeshCollider::default(), far, Saved)).id();
    let cloth = (Mesh3d(SHEET), ClothMesh::default(), ClothPins::indices([0, CELLS]), turned(0.4), Saved);
    let cloth = app.world_mut().spawn((cloth, ClothQuality::High, ClothMaterial::silk())).id();
    run(&mut app, 60);
    set_transform(&mut app, cloth, turned(0.5));
    run(&mut app, 30);
    let file = save(&mut app);
    let record = |app: &mut App, cloth: Entity| -> Vec<_> {
        let frame = |_| {
            app.update();
            state(app, cloth).cloth().positions().to_vec()
        };
        (0..40).map(frame).collect()
    };

    let mut other = app_with_sheet();
    (0..7).for_each(|_| _ = other.world_mut().spawn_empty());
    let map = load(&mut other, &file);
    // In the frame that it starts in there is no step.
    other.update();
    let [cloth_again, ball_again, wall_again] = [cloth, ball, wall].map(|entity| map[&entity]);
    assert!(error(&other, cloth_again).is_none(), "{:?}", error(&other, cloth_again));
    assert_eq!(state(&other, cloth_again).source_mesh(), &SHEET);
    assert_eq!(id(&other, ball_again), id(&app, ball));
    assert!(other.world().get::<ClothCollider>(wall_again).is_some());
    let before = state(&app, cloth).cloth().positions().to_vec();
    assert_eq!(state(&other, cloth_again).cloth().positions(), before);
    assert!(record(&mut other, cloth_again) == record(&mut app, cloth));
    let ids: Vec<_> = [&mut app, &mut other]
        .map(|app| app.world_mut().spawn(ClothCollider::sphere(1.0)).id())
        .into_iter()
        .zip([&app, &other])
        .map(|(entity, app)| id(app, entity))
        .collect();
    assert!(ids[0] > id(&app, cloth) && ids[1] > id(&app, cloth), "{ids:?}");
}

/// The halves of the sheet, likewise.
const HALVES: [Handle<Mesh>; 2] =
    [uuid_handle!("3d9a7c1e-6c1b-4c0e-9f63-2a5d0f3c8b12"), uuid_handle!("3d9a7c1e-6c1b-4c0e-9f63-2a5d0f3c8b13")];

#[test]
fn a_cloth_of_several_meshes_goes_on_after_loading() {
    let app_with_halves = || {
        let mut app = app_with_sheet();
        app.register_type::<ChildOf>().register_type::<Children>();
        for (handle, half) in HALVES.iter().zip(crate::parts::halves()) {
            app.world_mut().resource_mut::<Assets<Mesh>>().insert(handle, half).unwrap();
        }
        app
    };
    let mut app = app_with_halves();
    let node = (ClothMesh::default(), ClothPins::indices([0, 1]), Transform::from_rotation(Quat::from_rotation_y(0.4)));
    let node = app.world_mut().spawn((node, Saved)).id();
    for half in HALVES {
        app.world_mut().spawn((Mesh3d(half), ChildOf(node), Saved));
    }
    run(&mut app, 60);
    let file = save(&mut app);

    let mut other = app_with_halves();
    (0..7).for_each(|_| _ = other.world_mut().spawn_empty());
    let again = load(&mut other, &file)[&node];
    other.update();
    assert!(error(&other, again).is_none(), "{:?}", error(&other, again));
    let sources: Vec<_> = state(&other, again).parts().iter().map(|part| part.source_mesh().clone()).collect();
    assert_eq!(sources, HALVES);
    for _ in 0..20 {
        assert!(state(&other, again).cloth().positions() == state(&app, node).cloth().positions());
        run(&mut app, 1);
        run(&mut other, 1);
    }
}
