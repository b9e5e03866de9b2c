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
mod copies;
mod debug;
mod determinism;
mod diagnostics;
mod errors;
mod flag;
mod jumps;
mod lifecycle;
mod motion;
mod order;
mod parts;
mod picture;
mod pins;
#[cfg(feature = "avian3d")]
mod pushes;
mod quality;
#[cfg(feature = "rapier3d")]
mod rapier;
mod reflect;
#[cfg(feature = "serialize")]
mod saving;
mod shading;
mod snapshot;
mod stage;
mod start;
mod time;
mod transform;
mod words;
