//! From a triangle mesh to the [`RestShape`] that the elements are made of:
//! weld → clean triangles → edges and hinges → warp and weft.

mod rest_shape;
mod t_junctions;
mod topology;
mod warp_weft;
mod weld;

pub use rest_shape::{BendingModel, Hinge, MeshError, RestShape, RestShapeOptions, SurfaceMesh, Triangle};
