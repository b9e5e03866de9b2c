//! The laboratory: measures bevy_cloth, free of anything that draws.
//!
//! One folder per subcommand ([`mod@bench`], [`validate`], [`trade`], [`stability`], [`mod@budget`], [`contact`], [`game`]), beside what they share:
//! [`scenes`] that others have measured too, the [`matrix`] of a cloth, [`memory`] in use, levels of [`mod@quality`],
//! [`report`]s as tables and JSON, [`row`]s that are judged, and [`plot`]s as pictures.

#![warn(missing_docs)]

pub mod bench;
pub mod budget;
pub mod contact;
pub mod game;
pub mod matrix;
pub mod memory;
pub mod plot;
pub mod quality;
pub mod report;
pub mod row;
pub mod scenes;
pub mod stability;
pub mod trade;
pub mod validate;
