//! Whatever mesh comes in, out comes cloth that works or an error that is right.

use bevy::math::DVec3;
use bevy_cloth::physics::{Cloth, Fabric, MeshError, RestShape, RestShapeOptions, SolverSettings};
use proptest::prelude::*;

use crate::cases;
use crate::generators::{Surface, any_bending};

/// Mostly ordinary, often the same as another, now and then absurd.
fn coordinate() -> impl Strategy<Value = f64> {
    prop_oneof![
        40 => -1.0..1.0,
        40 => (-2..3_i32).prop_map(|i| f64::from(i) * 0.5),
        4 => prop::sample::select(vec![1e-9, -1e-30, f64::MIN_POSITIVE, 5e-324, 1e5, 1e9, -1e20]),
        2 => prop::sample::select(vec![1e38, 1e100, 1e160, -1e300, f64::MAX]),
    ]
}

/// Coordinates of meshes that are not even finite.
fn any_coordinate() -> impl Strategy<Value = f64> {
    prop_oneof![
        100 => coordinate(),
        1 => prop::sample::select(vec![f64::NAN, f64::INFINITY, f64::NEG_INFINITY]),
    ]
}

/// Random triangles over random vertices: some name vertices that do not exist, the same vertex twice, or what others do.
pub fn any_mesh() -> impl Strategy<Value = Surface> {
    let positions = |finite: bool| {
        let coordinate = if finite { coordinate().boxed() } else { any_coordinate().boxed() };
        prop::collection::vec([coordinate.clone(), coordinate.clone(), coordinate], 0..24)
    };
    let positions = prop_oneof![3 => positions(true), 1 => positions(false)];
    positions.prop_flat_map(|positions| {
        let count = positions.len();
        let index = prop_oneof![400 => 0..count.max(1) as u32, 1 => any::<u32>(), 1 => Just(count as u32)];
        let triangles = prop::collection::vec([index.clone(), index.clone(), index], 0..40);
        let coordinate =
            prop_oneof![20 => -1.0_f32..1.0, 4 => Just(0.0), 1 => Just(f32::NAN), 1 => Just(f32::INFINITY)];
        let uvs = prop_oneof![1 => Just(0), 1 => Just(count + 1), 8 => Just(count)]
            .prop_flat_map(move |count| prop::collection::vec([coordinate.clone(), coordinate.clone()], count));
        (triangles, prop::option::of(uvs)).prop_map(move |(triangles, uvs)| Surface {
            positions: positions.iter().map(|&p| DVec3::from_array(p)).collect(),
            triangles,
            uvs,
        })
    })
}

fn any_options() -> impl Strategy<Value = RestShapeOptions> {
    let weld = prop_oneof![
        4 => Just(None),
        2 => prop::sample::select(vec![0.0, 1e-6, 0.3, 10.0]).prop_map(Some),
        1 => prop::sample::select(vec![f64::NAN, f64::INFINITY, -1.0]).prop_map(Some),
    ];
    (weld, any::<bool>(), -4.0..4.0, any::<bool>(), any_bending()).prop_map(
        |(weld_distance, warp_from_uvs, warp_angle, rest_flat, bending)| RestShapeOptions {
            weld_distance,
            warp_from_uvs,
            warp_angle,
            rest_flat,
            bending,
        },
    )
}

/// Whether an error says what is so.
fn is_right(error: &MeshError, mesh: &Surface) -> bool {
    let count = mesh.positions.len();
    match error {
        MeshError::Empty { given } => *given == mesh.triangles.len(),
        MeshError::IndexOutOfRange { triangle, vertex, count: told } => {
            *told == count && *vertex as usize >= count && mesh.triangles[*triangle].contains(vertex)
        }
        MeshError::NotFinite { vertex } => !mesh.positions[*vertex].is_finite(),
        MeshError::UvCount { uvs, positions } => {
            *positions == count && mesh.uvs.as_ref().is_some_and(|given| given.len() == *uvs) && *uvs != count
        }
        // Another would be wrong here.
        _ => false,
    }
}

proptest! {
    #![proptest_config(cases(1500))]

    #[test]
    fn a_mesh_gives_cloth_that_works_or_an_error_that_is_right(mesh in any_mesh(), options in any_options()) {
        let shape = match RestShape::new(&mesh.mesh(), &options) {
            Ok(shape) => shape,
            Err(error) => {
                prop_assert!(is_right(&error, &mesh), "{error}");
                return Ok(());
            }
        };
        let count = shape.vertex_count();
        prop_assert_eq!(shape.triangles.len() + shape.dropped.len(), mesh.triangles.len());
        prop_assert_eq!(shape.simulated.len(), mesh.positions.len());
        let mut used = vec![false; count];
        for triangle in &shape.triangles {
            prop_assert!(triangle.area > 0.0 && triangle.area.is_finite(), "{triangle:?}");
            prop_assert!(triangle.dm_inverse.as_flattened().iter().all(|entry| entry.is_finite()), "{triangle:?}");
            let source = mesh.triangles[triangle.source as usize];
            // The simulated vertices of the triangle are those of its corners in the mesh.
            prop_assert_eq!(source.map(|v| shape.simulated[v as usize]), triangle.vertices.map(Some));
            triangle.vertices.iter().for_each(|&v| used[v as usize] = true);
        }
        prop_assert!(used.iter().all(|&used| used), "a vertex without triangle is simulated");

        let mut cloth = Cloth::new(shape, Fabric::cotton(), SolverSettings::default()).expect("a valid fabric");
        prop_assert!(cloth.masses().iter().all(|&mass| mass > 0.0 && mass.is_finite()));
        cloth.pin(0, cloth.positions()[0]);
        for _ in 0..3 {
            cloth.step(1.0 / 60.0);
            prop_assert!(cloth.positions().iter().chain(cloth.velocities()).all(|v| v.is_finite()));
        }
    }
}
