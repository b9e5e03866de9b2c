//! The plugin, in headless apps.

mod budget;
mod common;
mod contact;
mod contact_choice;
mod contact_errors;
mod contact_mesh;
mod debug;
mod diagnostics;
mod errors;
mod lifecycle;
mod order;
mod pins;
mod quality;
mod reflect;
mod shading;
mod start;
mod time;
mod transform;
