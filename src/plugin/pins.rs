//! Which vertices are held.

use std::borrow::Cow;
use std::fmt;
use std::sync::Arc;

use bevy::mesh::{MeshVertexAttribute, VertexAttributeValues, VertexFormat};
use bevy::prelude::*;

use super::error::ClothError;

/// Weight of a vertex's pin: above ½ it is held by [`ClothPins::default`].
///
/// For a glTF attribute `_CLOTH_PIN`, add
/// `GltfPlugin::default().add_custom_vertex_attribute("CLOTH_PIN", ATTRIBUTE_CLOTH_PIN)` to the app: Bevy takes the
/// underscore away.
pub const ATTRIBUTE_CLOTH_PIN: MeshVertexAttribute =
    MeshVertexAttribute::new("ClothPin", 0x00c1_07b8_91a5_3e42, VertexFormat::Float32);

/// The vertices that are held at their place in the mesh, wherever the entity's transform takes it. Of a cloth of several meshes, see
/// [`ClothMesh`](super::ClothMesh).
///
/// By default the vertices whose [`ATTRIBUTE_CLOTH_PIN`] is above ½, if the mesh has it; else none, and the cloth moves
/// freely in the world. A cloth without pins follows its transform only when it starts and when it is teleported.
///
/// ```
/// # use bevy::prelude::*;
/// # use bevy_cloth::plugin::ClothPins;
/// let corners_and_hem = ClothPins::indices([0, 15]).or(ClothPins::where_position(|p| p.y < 0.01));
/// ```
#[derive(Component, Clone, Debug, Reflect)]
#[cfg_attr(feature = "serialize", derive(serde::Serialize, serde::Deserialize), reflect(Serialize, Deserialize))]
#[reflect(Component, Default, Clone, Debug)]
pub struct ClothPins {
    /// A vertex is held if any of these says so.
    pub rules: Vec<PinRule>,
    /// As `rules`, but code: neither reflected nor serialized.
    #[reflect(ignore)]
    #[cfg_attr(feature = "serialize", serde(skip))]
    predicates: Vec<PinPredicate>,
    /// How many predicates there were, so that one who comes back without them can tell.
    #[reflect(default)]
    #[cfg_attr(feature = "serialize", serde(default))]
    predicate_count: usize,
}

/// A rule that chooses vertices. Indices, attributes and positions are those of the mesh asset, before the entity's transform.
#[derive(Clone, Debug, Default, PartialEq, Reflect)]
#[cfg_attr(feature = "serialize", derive(serde::Serialize, serde::Deserialize))]
#[reflect(Default, Clone, PartialEq)]
pub enum PinRule {
    /// [`ATTRIBUTE_CLOTH_PIN`] above ½; nothing on a mesh without it. The default.
    #[default]
    Authored,
    /// These vertices.
    Indices(Vec<u32>),
    /// The attribute of this name, one f32 per vertex, is above the threshold.
    Attribute {
        /// [`MeshVertexAttribute::name`].
        name: String,
        /// Lower bound.
        threshold: f32,
    },
    /// The channel of [`Mesh::ATTRIBUTE_COLOR`] is above the threshold. The attribute has four f32 a vertex, or four 8-bit or
    /// 16-bit numbers that stand for 0 to 1.
    Color {
        /// The channel.
        channel: PinChannel,
        /// Lower bound.
        threshold: f32,
    },
    /// Inside an axis-aligned box, borders included, in the space of the mesh.
    Box {
        /// Lower corner.
        min: Vec3,
        /// Upper corner.
        max: Vec3,
    },
}

/// A channel of a vertex color: red if nothing is said.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Reflect)]
#[cfg_attr(feature = "serialize", derive(serde::Serialize, serde::Deserialize))]
#[reflect(Default, Clone, PartialEq)]
#[expect(missing_docs, reason = "the names say it")]
pub enum PinChannel {
    #[default]
    Red,
    Green,
    Blue,
    Alpha,
}

/// A vertex that a predicate decides on, in the space of the mesh.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PinVertex {
    /// Index in the mesh.
    pub index: u32,
    /// Rest position.
    pub position: Vec3,
    /// Rest normal, of length 1.
    pub normal: Vec3,
    /// [`Mesh::ATTRIBUTE_UV_0`].
    pub uv: Option<Vec2>,
    /// [`Mesh::ATTRIBUTE_COLOR`].
    pub color: Option<Vec4>,
}

#[derive(Clone)]
struct PinPredicate(Arc<dyn Fn(&PinVertex) -> bool + Send + Sync>);

impl fmt::Debug for PinPredicate {
    fn fmt(&self, f: &mut fmt::Formatter) -> fmt::Result {
        f.write_str("predicate")
    }
}

impl Default for ClothPins {
    fn default() -> Self {
        PinRule::Authored.into()
    }
}

impl From<PinRule> for ClothPins {
    fn from(rule: PinRule) -> Self {
        Self { rules: vec![rule], ..Self::none() }
    }
}

impl ClothPins {
    /// No vertex, whatever the mesh says.
    pub const fn none() -> Self {
        Self { rules: Vec::new(), predicates: Vec::new(), predicate_count: 0 }
    }

    /// These vertices of the mesh.
    pub fn indices(indices: impl IntoIterator<Item = u32>) -> Self {
        PinRule::Indices(indices.into_iter().collect()).into()
    }

    /// Vertices whose rest position satisfies the predicate. The position is that in the mesh asset, before the entity's
    /// transform.
    ///
    /// A predicate is code: it is not in a saved scene. [`ClothPins::in_box`] is.
    pub fn where_position(predicate: impl Fn(Vec3) -> bool + Send + Sync + 'static) -> Self {
        Self::where_vertex(move |vertex| predicate(vertex.position))
    }

    /// Vertices that satisfy the predicate.
    ///
    /// A predicate is code: it is not in a saved scene. A component that is loaded from there says in a warning how many it has
    /// lost; the rules that are no code are kept.
    pub fn where_vertex(predicate: impl Fn(&PinVertex) -> bool + Send + Sync + 'static) -> Self {
        Self { rules: Vec::new(), predicates: vec![PinPredicate(Arc::new(predicate))], predicate_count: 1 }
    }

    /// Vertices whose attribute (one f32 each) is above `threshold`.
    pub fn where_attribute(attribute: MeshVertexAttribute, threshold: f32) -> Self {
        PinRule::Attribute { name: attribute.name.into(), threshold }.into()
    }

    /// Vertices whose color is above `threshold` in this channel.
    pub fn where_color(channel: PinChannel, threshold: f32) -> Self {
        PinRule::Color { channel, threshold }.into()
    }

    /// Vertices inside an axis-aligned box in the space of the mesh, borders included.
    pub fn in_box(min: Vec3, max: Vec3) -> Self {
        PinRule::Box { min, max }.into()
    }

    /// What either holds.
    pub fn or(mut self, other: Self) -> Self {
        self.rules.extend(other.rules);
        self.predicates.extend(other.predicates);
        self.predicate_count += other.predicate_count;
        self
    }

    /// Predicates that it had before it was saved and loaded again.
    pub(super) fn lost_predicates(&self) -> usize {
        self.predicate_count.saturating_sub(self.predicates.len())
    }

    /// Whether it is meant to hold something on any mesh.
    pub(super) fn asks_for_vertices(&self) -> bool {
        let asks = |rule: &PinRule| match rule {
            PinRule::Authored => false,
            PinRule::Indices(indices) => !indices.is_empty(),
            _ => true,
        };
        !self.predicates.is_empty() || self.rules.iter().any(asks)
    }

    /// The vertices of a cloth that are held, in order. The slices give the rest state, the meshes of its parts, each with the number of
    /// its vertices, the attributes.
    pub(super) fn resolve(
        &self,
        parts: &[(&Mesh, usize)],
        positions: &[Vec3],
        normals: &[Vec3],
    ) -> Result<Vec<u32>, ClothError> {
        let mut held = vec![false; positions.len()];
        for rule in &self.rules {
            rule.mark(parts, positions, &mut held)?;
        }
        if !self.predicates.is_empty() {
            let mut first = 0;
            for (mesh, held) in by_part(parts, &mut held) {
                let uvs = match mesh.try_attribute(Mesh::ATTRIBUTE_UV_0) {
                    Ok(VertexAttributeValues::Float32x2(uvs)) => Some(uvs),
                    _ => None,
                };
                let colors = colors(mesh);
                for (of_part, held) in held.iter_mut().enumerate() {
                    let index = first + of_part;
                    let vertex = PinVertex {
                        index: index as u32,
                        position: positions[index],
                        normal: normals[index],
                        uv: uvs.and_then(|uvs| uvs.get(of_part)).map(|&uv| uv.into()),
                        color: colors.as_ref().and_then(|colors| colors.get(of_part)).map(|&color| color.into()),
                    };
                    *held |= self.predicates.iter().any(|predicate| predicate.0(&vertex));
                }
                first += held.len();
            }
        }
        Ok((0..).zip(held).filter_map(|(index, held)| held.then_some(index)).collect())
    }
}

impl PinRule {
    fn mark(&self, parts: &[(&Mesh, usize)], positions: &[Vec3], held: &mut [bool]) -> Result<(), ClothError> {
        match self {
            Self::Authored => {
                for (mesh, held) in by_part(parts, held) {
                    if let Some(weights) = attribute(mesh, ATTRIBUTE_CLOTH_PIN.name) {
                        mark_above(held, weights?.iter().copied(), 0.5);
                    }
                }
            }
            Self::Indices(indices) => {
                let count = held.len() as u32;
                for &vertex in indices {
                    *held.get_mut(vertex as usize).ok_or(ClothError::PinIndex { vertex, count })? = true;
                }
            }
            Self::Attribute { name, threshold } => {
                let mut has_it = false;
                for (mesh, held) in by_part(parts, held) {
                    if let Some(values) = attribute(mesh, name) {
                        mark_above(held, values?.iter().copied(), *threshold);
                        has_it = true;
                    }
                }
                if !has_it {
                    return Err(missing_attribute(name, VertexFormat::Float32, None));
                }
            }
            Self::Color { channel, threshold } => {
                let mut has_it = false;
                for (mesh, held) in by_part(parts, held) {
                    if let Some(colors) = colors(mesh) {
                        mark_above(held, colors.iter().map(|color| color[*channel as usize]), *threshold);
                        has_it = true;
                    }
                }
                if !has_it {
                    let found = parts.iter().find_map(|(mesh, _)| mesh.try_attribute(Mesh::ATTRIBUTE_COLOR).ok());
                    return Err(missing_attribute(Mesh::ATTRIBUTE_COLOR.name, VertexFormat::Float32x4, found));
                }
            }
            Self::Box { min, max } => {
                for (held, position) in held.iter_mut().zip(positions) {
                    *held |= position.cmpge(*min).all() && position.cmple(*max).all();
                }
            }
        }
        Ok(())
    }
}

/// What belongs to each part.
fn by_part<'a>(
    parts: &'a [(&'a Mesh, usize)],
    mut held: &'a mut [bool],
) -> impl Iterator<Item = (&'a Mesh, &'a mut [bool])> {
    parts.iter().map(move |&(mesh, count)| {
        let (of_part, rest) = core::mem::take(&mut held).split_at_mut(count);
        held = rest;
        (mesh, of_part)
    })
}

fn mark_above(held: &mut [bool], values: impl Iterator<Item = f32>, threshold: f32) {
    for (held, value) in held.iter_mut().zip(values) {
        *held |= value > threshold;
    }
}

fn colors(mesh: &Mesh) -> Option<Cow<'_, [[f32; 4]]>> {
    match mesh.try_attribute(Mesh::ATTRIBUTE_COLOR) {
        Ok(VertexAttributeValues::Float32x4(colors)) => Some(colors.into()),
        Ok(VertexAttributeValues::Unorm8x4(colors)) => {
            Some(colors.iter().map(|color| color.map(|channel| f32::from(channel) / f32::from(u8::MAX))).collect())
        }
        Ok(VertexAttributeValues::Unorm16x4(colors)) => {
            Some(colors.iter().map(|color| color.map(|channel| f32::from(channel) / f32::from(u16::MAX))).collect())
        }
        _ => None,
    }
}

/// The f32 attribute of this name; `None` if there is no attribute of the name.
fn attribute<'a>(mesh: &'a Mesh, name: &str) -> Option<Result<&'a [f32], ClothError>> {
    let (_, values) = mesh.try_attributes().ok()?.find(|(attribute, _)| attribute.name == name)?;
    Some(match values {
        VertexAttributeValues::Float32(values) => Ok(values),
        _ => Err(missing_attribute(name, VertexFormat::Float32, Some(values))),
    })
}

fn missing_attribute(name: &str, format: VertexFormat, found: Option<&VertexAttributeValues>) -> ClothError {
    ClothError::PinAttribute {
        attribute: name.into(),
        format: format!("{format:?}"),
        found: found.map_or("none".into(), |values| format!("{:?}", VertexFormat::from(values))),
    }
}
