//! The physics core, without an App.

mod analytic;
mod assembly;
mod bending;
mod carry;
mod contact;
mod contact_between;
mod contact_repairs;
mod contact_surfaces;
mod derivatives;
mod determinism;
mod extremes;
mod meshes;
mod newton;
mod pins;
mod preconditioners;
mod quality;
mod remeasure;
mod rest_shape;
mod snapshot;
mod solvers;
mod steps;
