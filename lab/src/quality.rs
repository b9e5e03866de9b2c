//! Levels of quality on the command line and in JSON.

use bevy_cloth::physics::Quality;
use clap::builder::{PossibleValuesParser, TypedValueParser};
use serde::Serializer;

/// Reads a level by its name.
pub fn parser() -> impl TypedValueParser<Value = Quality> {
    PossibleValuesParser::new(Quality::ALL.map(Quality::name)).map(|name| Quality::by_name(&name).unwrap_or_default())
}

/// Writes the name of a level.
///
/// # Errors
/// Those of the serialiser.
pub fn serialize<S: Serializer>(quality: &Quality, serializer: S) -> Result<S::Ok, S::Error> {
    serializer.serialize_str(quality.name())
}
