//! What the examples share. [`run::run`] takes a scene and shows it the best way the machine allows: in a window with
//! an orbit camera, keys and an overlay, off-screen to pictures, or to a mesh alone; the rest are its parts.

pub mod banner;
pub mod capture;
pub mod cli;
pub mod clock;
pub mod controls;
pub mod export;
pub mod glb;
pub mod host;
pub mod lathe;
pub mod off_screen;
pub mod orbit_camera;
pub mod overlay;
pub mod paint;
pub mod penetration;
pub mod pleats;
pub mod plugins;
pub mod props;
pub mod rod;
pub mod run;
pub mod scene;
pub mod sheet;
pub mod stage;
pub mod summary;
pub mod windowed;

/// What the README shows compiles. It is here because here is all that draws.
#[cfg(doctest)]
#[doc = include_str!("../../README.md")]
struct Readme;
