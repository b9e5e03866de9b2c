//! The physics core, without an App.

mod analytic;
mod assembly;
mod bending;
mod derivatives;
mod determinism;
mod meshes;
mod pins;
mod preconditioners;
mod rest_shape;
mod solvers;
mod steps;
