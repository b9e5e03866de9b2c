//! Features of shapes, found once for all cloths: a mesh of a hundred thousand triangles takes a tenth of a second.

use std::collections::HashMap;
use std::sync::{Arc, Mutex, PoisonError, Weak};

use parry3d::shape::{Shape, SharedShape};

use super::features::Features;

/// By the address of the shape, which stays its own as long as the weak pointer is kept.
type Known = HashMap<usize, (Weak<dyn Shape>, Arc<Features>)>;

static KNOWN: Mutex<Option<Known>> = Mutex::new(None);

/// The features of a shape. They are kept as long as the shape is. While they are found, other cloths that need any wait: most often
/// they are near the same shape.
pub(super) fn features_of(shape: &SharedShape) -> Arc<Features> {
    let mut known = KNOWN.lock().unwrap_or_else(PoisonError::into_inner);
    let known = known.get_or_insert_default();
    let address = Arc::as_ptr(&shape.0).cast::<()>() as usize;
    if let Some((_, features)) = known.get(&address).filter(|(its, _)| its.strong_count() > 0) {
        return features.clone();
    }
    known.retain(|_, (its, _)| its.strong_count() > 0);
    let features = Arc::new(Features::new(shape));
    known.insert(address, (Arc::downgrade(&shape.0), features.clone()));
    features
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn they_are_found_once_for_a_shape_and_forgotten_with_it() {
        let count = || KNOWN.lock().unwrap().as_ref().map_or(0, |known| known.len());
        let shape = SharedShape::cuboid(0.1, 0.2, 0.3);
        let first = features_of(&shape);
        assert!(Arc::ptr_eq(&first, &features_of(&shape.clone())));
        assert!(!Arc::ptr_eq(&first, &features_of(&SharedShape::cuboid(0.1, 0.2, 0.3))));
        let weak = Arc::downgrade(&first);
        drop((first, shape));
        assert!(count() > 0);
        features_of(&SharedShape::ball(0.1));
        assert_eq!(weak.strong_count(), 0, "the next that is new clears up");
    }
}
