//! The plugin, in headless apps.

#[cfg(feature = "avian3d")]
mod avian;
mod budget;
mod common;
mod contact;
mod contact_choice;
mod contact_errors;
mod contact_mesh;
mod contact_shear;
mod debug;
mod diagnostics;
mod errors;
mod lifecycle;
mod order;
mod pins;
#[cfg(feature = "avian3d")]
mod pushes;
mod quality;
#[cfg(feature = "rapier3d")]
mod rapier;
mod reflect;
mod shading;
mod start;
mod time;
mod transform;
