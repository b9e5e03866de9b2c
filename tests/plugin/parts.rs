//! One cloth of several meshes, as a glTF file has a mesh of several materials: each is a child of the node with the cloth.

use bevy::camera::primitives::Aabb;
use bevy::camera::visibility::NoAutoAabb;
use bevy::ecs::entity::EntityCloner;
use bevy::mesh::skinning::SkinnedMesh;
use bevy::prelude::*;
use bevy_cloth::plugin::*;

use crate::common::*;

/// Columns of cells that the left part has.
const LEFT: u32 = 2;

/// [`sheet`] as two meshes with the border in common, each with its own vertices.
pub fn halves() -> [Mesh; 2] {
    let whole = sheet();
    let places = vectors(&whole, Mesh::ATTRIBUTE_POSITION);
    let border = LEFT as f32 / CELLS as f32;
    [true, false].map(|left| {
        let kept =
            |&[a, b, c]: &[usize; 3]| ([a, b, c].iter().map(|&v| places[v].x).sum::<f32>() / 3.0 < border) == left;
        let indices: Vec<usize> = whole.indices().expect("indices").iter().collect();
        let triangles: Vec<[usize; 3]> = indices.as_chunks().0.iter().copied().filter(kept).collect();
        let mut used: Vec<usize> = triangles.concat();
        used.sort_unstable();
        used.dedup();
        let index = |v: &usize| used.binary_search(v).expect("used") as u32;
        let uv = |v: &usize| [places[*v].x, -places[*v].y];
        Mesh::new(whole.primitive_topology(), default())
            .with_inserted_attribute(Mesh::ATTRIBUTE_POSITION, used.iter().map(|&v| places[v]).collect::<Vec<_>>())
            .with_inserted_attribute(Mesh::ATTRIBUTE_NORMAL, vec![[0.0, 0.0, 1.0]; used.len()])
            .with_inserted_attribute(Mesh::ATTRIBUTE_UV_0, used.iter().map(uv).collect::<Vec<_>>())
            .with_inserted_indices(bevy::mesh::Indices::U32(triangles.concat().iter().map(index).collect()))
    })
}

/// Both halves as one mesh, the vertices in the order of the parts.
fn joined() -> Mesh {
    let [mut left, right] = halves();
    left.merge(&right).expect("the same attributes");
    left
}

/// A node with a child for each mesh, and lets it start.
fn spawn_node(app: &mut App, meshes: impl IntoIterator<Item = Mesh>, bundle: impl Bundle) -> (Entity, Vec<Entity>) {
    let spawned = add_node(app, meshes.into_iter().map(|mesh| (mesh, Transform::IDENTITY)), bundle);
    app.update();
    spawned
}

/// A node with a child for each mesh, at these places in it.
fn add_node(
    app: &mut App,
    meshes: impl IntoIterator<Item = (Mesh, Transform)>,
    bundle: impl Bundle,
) -> (Entity, Vec<Entity>) {
    let node = app.world_mut().spawn((ClothMesh::default(), bundle)).id();
    let parts = meshes.into_iter().map(|(mesh, place)| {
        let mesh3d = Mesh3d(add_mesh(app, mesh));
        app.world_mut().spawn((mesh3d, place, ChildOf(node))).id()
    });
    (node, parts.collect())
}

/// The top edge of the left half.
fn left_top() -> ClothPins {
    ClothPins::where_position(|p| p.y > -0.01 && p.x < 0.6)
}

fn at(app: &App, entity: Entity) -> Vec3 {
    app.world().get::<GlobalTransform>(entity).expect("a transform").translation()
}

/// Pairs of vertices of both meshes that are at one place at rest.
fn border() -> Vec<(usize, usize)> {
    let [left, right] = halves().map(|half| vectors(&half, Mesh::ATTRIBUTE_POSITION));
    let pairs = left.iter().enumerate().filter_map(|(i, p)| Some((i, right.iter().position(|q| q == p)?)));
    let pairs: Vec<_> = pairs.collect();
    assert_eq!(pairs.len() as u32, CELLS + 1);
    pairs
}

#[test]
fn the_border_stays_closed_and_smooth_and_moves_as_one_mesh() {
    let mut app = app();
    let bundle = || (left_top(), Transform::from_xyz(0.0, 3.0, 0.0));
    let (node, parts) = add_node(&mut app, halves().map(|half| (half, Transform::IDENTITY)), bundle());
    // Vertices in the order of the parts; and in another, so that sums are rounded otherwise.
    let [one, whole] = [joined(), sheet()].map(|mesh| {
        let mesh3d = Mesh3d(add_mesh(&mut app, mesh));
        app.world_mut().spawn((mesh3d, ClothMesh::default(), bundle())).id()
    });
    app.update();
    for frame in 0..64 {
        for cloth in [node, one, whole] {
            let there = Vec3::new(0.1 * (frame as f32 * 0.2).sin(), 3.0, 0.0);
            set_transform(&mut app, cloth, Transform::from_translation(there));
        }
        app.update();
    }
    assert!(error(&app, node).is_none() && app.world().get::<Mesh3d>(node).is_none());
    let shown: Vec<Vec<Vec3>> = parts.iter().map(|&part| local(&app, part)).collect();
    let normals: Vec<Vec<Vec3>> = parts.iter().map(|&part| vectors(mesh(&app, part), Mesh::ATTRIBUTE_NORMAL)).collect();
    assert!(shown[1].iter().any(|p| p.z.abs() > 0.05), "it swings");
    for (l, r) in border() {
        assert_eq!(shown[0][l], shown[1][r], "no gap at all");
        assert_eq!(normals[0][l], normals[1][r]);
    }
    assert_eq!(shown.concat(), local(&app, one), "to the last bit");
    assert_eq!(normals.concat(), vectors(mesh(&app, one), Mesh::ATTRIBUTE_NORMAL));
    let [rest, whole_rest] = [joined(), sheet()].map(|mesh| vectors(&mesh, Mesh::ATTRIBUTE_POSITION));
    let (whole, whole_normals) = (local(&app, whole), vectors(mesh(&app, whole), Mesh::ATTRIBUTE_NORMAL));
    for ((place, normal), rest) in shown.concat().iter().zip(normals.concat()).zip(rest) {
        let vertex = whole_rest.iter().position(|p| *p == rest).expect("the same vertices");
        assert_near(*place, whole[vertex], 1e-4);
        assert_near(normal, whole_normals[vertex], 1e-3);
    }
}

#[test]
fn each_part_keeps_its_entity_and_has_its_own_bounds() {
    let mut app = app();
    let (node, parts) = spawn_node(&mut app, halves(), left_top());
    // A part that is hidden is simulated all the same.
    app.world_mut().entity_mut(parts[1]).insert(Visibility::Hidden);
    let sources: Vec<_> = state(&app, node).parts().iter().map(|part| part.source_mesh().clone()).collect();
    run(&mut app, 30);
    let ranges: Vec<_> = state(&app, node).parts().iter().map(|part| (part.entity(), part.vertices())).collect();
    let half = (LEFT + 1) * (CELLS + 1);
    assert_eq!(ranges, [(parts[0], 0..half), (parts[1], half..2 * half)]);
    for (l, r) in border() {
        assert_eq!(local(&app, parts[0])[l], local(&app, parts[1])[r]);
    }
    let all: Vec<_> = parts.iter().flat_map(|&part| local(&app, part)).collect();
    assert_eq!(
        app.world().get::<Aabb>(node),
        Aabb::enclosing(all).as_ref(),
        "for those who ask how large the cloth is"
    );
    for (part, source) in parts.into_iter().zip(sources) {
        assert_ne!(app.world().get::<Mesh3d>(part).unwrap().0, source, "a copy of its own");
        assert_eq!(app.world().get::<ClothSource>(part), Some(&ClothSource(source)));
        assert_eq!(app.world().get::<Aabb>(part), Aabb::enclosing(local(&app, part)).as_ref());
        assert!(app.world().get::<NoAutoAabb>(part).is_some());
    }
}

/// What is said of pins is said of all parts together.
#[test]
fn pins_are_those_of_the_whole() {
    let red = |left: &mut Mesh| {
        let red = |p: &Vec3| if p.y > -0.01 { Vec4::ONE } else { Vec4::W }.to_array();
        let colors: Vec<[f32; 4]> = vectors(left, Mesh::ATTRIBUTE_POSITION).iter().map(red).collect();
        left.insert_attribute(Mesh::ATTRIBUTE_COLOR, colors);
    };
    let half = (LEFT + 1) * (CELLS + 1);
    let tops = |first: u32| first..first + LEFT + 1;
    let by_color = || ClothPins::where_color(PinChannel::Red, 0.5);
    let held = |meshes: [Mesh; 2], pins: ClothPins| {
        let mut app = app();
        let (node, parts) = spawn_node(&mut app, meshes, pins);
        run(&mut app, 200);
        assert!(error(&app, node).is_none(), "{:?}", error(&app, node));
        // Both halves hang from it, whoever is held.
        let lowest = parts.iter().flat_map(|&part| world(&app, part)).map(|p| p.y).fold(0.0, f32::min);
        assert!(lowest > -2.0, "{lowest}");
        state(&app, node).pinned_vertices().to_vec()
    };
    let [mut left, right] = halves();
    red(&mut left);
    assert_eq!(held([left.clone(), right.clone()], by_color()), tops(0).collect::<Vec<_>>(), "one has colors");
    let mut red_right = right;
    red(&mut red_right);
    let both: Vec<_> = tops(0).chain(tops(half)).collect();
    assert_eq!(held([left.clone(), red_right.clone()], by_color()), both, "each by its own");
    assert_eq!(held(halves(), top_edge()), both);
    assert_eq!(held(halves(), ClothPins::indices([half + 2])), [half + 2]);
    let vertex =
        ClothPins::where_vertex(move |vertex| vertex.color.is_some_and(|color| color.x > 0.5) && vertex.index > half);
    assert_eq!(held([left, red_right], vertex), [half + 1, half + 2]);
    // No mesh has any.
    let mut app = app();
    let (node, _) = spawn_node(&mut app, halves(), by_color());
    assert!(matches!(error(&app, node), Some(ClothError::PinAttribute { .. })));
}

/// Where a child stands against the node, mirrored and all, the cloth is the same one.
#[test]
fn a_part_may_have_a_place_of_its_own() {
    let mut app = app();
    let place = Transform {
        translation: Vec3::new(3.0, 1.0, -2.0),
        rotation: Quat::from_rotation_y(1.0),
        scale: Vec3::new(-0.5, 2.0, 1.5),
    };
    let [left, right] = halves();
    let moved = {
        let inward = place.to_matrix().inverse();
        let places: Vec<Vec3> =
            vectors(&right, Mesh::ATTRIBUTE_POSITION).iter().map(|&p| inward.transform_point3(p)).collect();
        let mut moved = right.clone().with_inserted_attribute(Mesh::ATTRIBUTE_POSITION, places);
        // Wound as the mirror will have it.
        moved.invert_winding().expect("triangles");
        moved.with_computed_smooth_normals()
    };
    let (node, parts) = add_node(&mut app, [(left.clone(), Transform::IDENTITY), (moved, place)], top_edge());
    let (plain, plain_parts) = add_node(&mut app, [left, right].map(|half| (half, Transform::IDENTITY)), top_edge());
    app.update();
    for frame in 0..64 {
        let there = Transform::from_xyz(0.0, 2.0, 0.1 * (frame as f32 * 0.2).sin());
        [node, plain].into_iter().for_each(|node| set_transform(&mut app, node, there));
        app.update();
    }
    for (part, plain) in parts.iter().zip(&plain_parts) {
        let matrix = app.world().get::<GlobalTransform>(*part).unwrap().affine().matrix3;
        let normals = vectors(mesh(&app, *part), Mesh::ATTRIBUTE_NORMAL);
        let of_plain = vectors(mesh(&app, *plain), Mesh::ATTRIBUTE_NORMAL);
        for (a, b) in world(&app, *part).into_iter().zip(world(&app, *plain)) {
            assert_near(a, b, 1e-3);
        }
        for (a, b) in normals.into_iter().zip(of_plain) {
            assert!((a.length() - 1.0).abs() < 1e-5);
            assert_near((matrix.inverse().transpose() * a).normalize(), b, 1e-2);
        }
        let bounds = app.world().get::<Aabb>(*part).unwrap();
        assert_eq!(*bounds, Aabb::enclosing(local(&app, *part)).unwrap());
    }
}

#[test]
fn a_part_that_goes_leaves_a_cloth_of_the_others() {
    let mut app = app();
    let (node, parts) = spawn_node(&mut app, halves(), left_top());
    run(&mut app, 20);
    app.world_mut().despawn(parts[1]);
    run(&mut app, 20);
    assert!(error(&app, node).is_none());
    assert_eq!(state(&app, node).parts().len(), 1);
    assert_eq!(local(&app, parts[0]).len() as u32, (LEFT + 1) * (CELLS + 1));
    assert!(state(&app, node).last_report().is_some(), "it goes on");

    // One that moves out stays as it is draped, a mesh like any other.
    let (node, parts) = spawn_node(&mut app, halves(), left_top());
    run(&mut app, 20);
    app.world_mut().entity_mut(parts[1]).remove::<ChildOf>();
    app.update();
    let draped = local(&app, parts[1]);
    run(&mut app, 10);
    assert_eq!(local(&app, parts[1]), draped);
    assert!(app.world().get::<NoAutoAabb>(parts[1]).is_none() && app.world().get::<ClothSource>(parts[1]).is_none());
    // And comes back.
    app.world_mut().entity_mut(parts[1]).insert(ChildOf(node));
    run(&mut app, 3);
    assert_eq!(state(&app, node).parts().len(), 2);
    for (l, r) in border() {
        assert_eq!(local(&app, parts[0])[l], local(&app, parts[1])[r]);
    }
    // Without any, there is no cloth.
    parts.iter().for_each(|&part| _ = app.world_mut().despawn(part));
    run(&mut app, 2);
    assert!(matches!(error(&app, node), Some(ClothError::NoMesh)));
    assert!(app.world().get::<ClothState>(node).is_none());
}

#[test]
fn a_cloth_that_ends_leaves_its_parts_as_they_are_draped() {
    let mut app = app();
    let (node, parts) = spawn_node(&mut app, halves(), left_top());
    run(&mut app, 20);
    app.world_mut().entity_mut(node).remove::<ClothMesh>();
    run(&mut app, 2);
    let draped = parts.iter().map(|&part| local(&app, part)).collect::<Vec<_>>();
    run(&mut app, 10);
    assert_eq!(parts.iter().map(|&part| local(&app, part)).collect::<Vec<_>>(), draped);
    assert!(app.world().get::<Aabb>(node).is_none() && app.world().get::<ClothState>(node).is_none());
    let left = |part: &Entity| {
        app.world().get::<NoAutoAabb>(*part).is_some() || app.world().get::<ClothSource>(*part).is_some()
    };
    assert!(!parts.iter().any(left));
}

#[test]
fn a_clone_with_its_children_is_a_cloth_of_the_same_sources() {
    let mut app = app();
    let (node, _) = spawn_node(&mut app, halves(), left_top());
    run(&mut app, 20);
    let clone = app.world_mut().spawn_empty().id();
    EntityCloner::build_opt_out(app.world_mut()).linked_cloning(true).clone_entity(node, clone);
    run(&mut app, 20);
    let sources =
        |app: &App, cloth| state(app, cloth).parts().iter().map(|part| part.source_mesh().id()).collect::<Vec<_>>();
    assert_eq!(sources(&app, clone), sources(&app, node));
    let own = |app: &App, cloth| state(app, cloth).parts().iter().map(|part| part.own_mesh().id()).collect::<Vec<_>>();
    assert!(own(&app, clone).iter().all(|mesh| !own(&app, node).contains(mesh)));
    assert!(state(&app, clone).last_report().is_some());
}

#[test]
fn meshes_of_parts_are_followed() {
    let mut app = app();
    let (node, parts) = spawn_node(&mut app, halves(), left_top());
    run(&mut app, 20);
    let source = state(&app, node).parts()[1].source_mesh().clone();
    // A color is taken over.
    let before = state(&app, node).cloth().positions().to_vec();
    let count = local(&app, parts[1]).len();
    let mut meshes = app.world_mut().resource_mut::<Assets<Mesh>>();
    meshes.get_mut(&source).unwrap().insert_attribute(Mesh::ATTRIBUTE_COLOR, vec![[1.0_f32; 4]; count]);
    run(&mut app, 2);
    assert!(mesh(&app, parts[1]).contains_attribute(Mesh::ATTRIBUTE_COLOR));
    assert!(!mesh(&app, parts[0]).contains_attribute(Mesh::ATTRIBUTE_COLOR));
    assert!(state(&app, node).cloth().positions()[COUNT as usize - 1].distance(before[COUNT as usize - 1]) < 0.5);
    // An own mesh that was removed is made again.
    let own = state(&app, node).parts()[1].own_mesh().clone();
    app.world_mut().resource_mut::<Assets<Mesh>>().remove(&own);
    run(&mut app, 2);
    assert_ne!(state(&app, node).parts()[1].own_mesh(), &own);
    for (l, r) in border() {
        assert_eq!(local(&app, parts[0])[l], local(&app, parts[1])[r]);
    }
    // Other positions build it again.
    let mut meshes = app.world_mut().resource_mut::<Assets<Mesh>>();
    *meshes.get_mut(&source).unwrap() = halves()[1].clone().translated_by(Vec3::X * 0.5);
    run(&mut app, 2);
    assert_eq!(state(&app, node).cloth().shape().vertex_count() as u32, 2 * (LEFT + 1) * (CELLS + 1), "no border");
}

#[test]
fn children_that_come_later_and_those_that_are_no_parts() {
    let mut app = app();
    let node = app.world_mut().spawn((ClothMesh::default(), left_top())).id();
    run(&mut app, 2);
    assert!(matches!(error(&app, node), Some(ClothError::NoMesh)));
    let [left, right] = halves().map(|half| Mesh3d(add_mesh(&mut app, half)));
    app.world_mut().spawn((left, ChildOf(node), SkinnedMesh::default()));
    run(&mut app, 2);
    assert!(error(&app, node).is_none() && state(&app, node).parts().len() == 1);
    let part = state(&app, node).parts()[0].entity();
    assert!(app.world().get::<SkinnedMesh>(part).is_none());
    // A cloth of its own, and a mesh further down.
    app.world_mut().spawn((right.clone(), ClothMesh::default(), ChildOf(node)));
    let below = app.world_mut().spawn((Transform::default(), ChildOf(node))).id();
    let deep = app.world_mut().spawn((right.clone(), ChildOf(below))).id();
    run(&mut app, 2);
    assert_eq!(state(&app, node).parts().len(), 1);
    assert_eq!(app.world().get::<Mesh3d>(deep), Some(&right));
    assert_near(at(&app, deep), at(&app, node), 0.0);
}

#[test]
fn an_index_out_of_range_is_none_of_another_part() {
    let mut app = app();
    let [mut left, right] = halves();
    left.insert_indices(bevy::mesh::Indices::U32(vec![0, 1, (LEFT + 1) * (CELLS + 1)]));
    let (node, _) = spawn_node(&mut app, [left, right], left_top());
    assert!(matches!(error(&app, node), Some(ClothError::Mesh(_))), "{:?}", error(&app, node));
}
