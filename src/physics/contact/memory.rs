//! What is remembered of touches from one substep to the next.

use bevy::math::DVec3;

use super::touch::{SURFACE, Touch};

/// Of one touch.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serialize", derive(serde::Serialize, serde::Deserialize))]
pub(crate) struct Memory {
    /// Id of the collider.
    pub collider: u64,
    pub feature: u32,
    pub vertices: [u32; 3],
    /// N of the last step, and of the one before, N.
    pub normal_force: f64,
    pub before: f64,
    /// In the frame of the collider, N.
    pub friction: DVec3,
    /// The way of slip in the frame of the collider, if it slipped.
    pub slipping: Option<DVec3>,
}

impl Memory {
    /// Whether every number is finite.
    pub fn is_finite(&self) -> bool {
        let Self { normal_force, before, friction, slipping, .. } = self;
        normal_force.is_finite()
            && before.is_finite()
            && friction.is_finite()
            && slipping.is_none_or(|way| way.is_finite())
    }
}

/// Of all touches.
#[derive(Default)]
pub(super) struct Memories(Vec<Memory>);

impl Memories {
    /// Replaces all by these.
    pub fn replace(&mut self, memories: impl Iterator<Item = Memory>) {
        self.0.clear();
        self.0.extend(memories);
        self.0.sort_unstable_by_key(|memory| (memory.collider, memory.feature, memory.vertices));
    }

    /// The touch of the step before, of the collider with this id. A corner may have come to another triangle since.
    pub fn recall(&self, collider: u64, touch: &Touch) -> Option<&Memory> {
        let key = (collider, touch.feature, touch.vertices);
        match self.0.binary_search_by_key(&key, |memory| (memory.collider, memory.feature, memory.vertices)) {
            Ok(index) => Some(&self.0[index]),
            Err(_) if touch.feature == SURFACE || touch.weights[2] == 0.0 => None,
            Err(index) => {
                let same = |memory: &&Memory| (memory.collider, memory.feature) == (collider, touch.feature);
                let shared = |memory: &&Memory| touch.vertices.iter().filter(|v| memory.vertices.contains(v)).count();
                let before = self.0[..index].iter().rev().take_while(same);
                let after = self.0[index..].iter().take_while(same);
                before.chain(after).filter(|memory| shared(memory) > 0).max_by_key(shared)
            }
        }
    }

    /// All of them.
    pub fn all(&self) -> &[Memory] {
        &self.0
    }

    pub fn is_empty(&self) -> bool {
        self.0.is_empty()
    }

    pub fn clear(&mut self) {
        self.0.clear();
    }
}
