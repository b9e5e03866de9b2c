//! Things that hang together.

/// Disjoint sets (Tarjan 1975) of numbers, each with whether it is opposite to the first of its set.
pub(super) struct Sets {
    /// Another of the set, nearer to the first, and whether both are opposite.
    parents: Vec<(u32, bool)>,
}

impl Sets {
    /// Numbers below `count`, each alone.
    pub fn new(count: usize) -> Self {
        Self { parents: (0..count as u32).map(|number| (number, false)).collect() }
    }

    /// The smallest of its set, and whether it is opposite to that.
    pub fn find(&mut self, number: u32) -> (u32, bool) {
        let (mut first, mut opposite) = (number, false);
        while self.parents[first as usize].0 != first {
            let (parent, turned) = self.parents[first as usize];
            (first, opposite) = (parent, opposite ^ turned);
        }
        // Shortens the way for the next time.
        let (mut at, mut left) = (number, opposite);
        while self.parents[at as usize].0 != first {
            let (parent, turned) = core::mem::replace(&mut self.parents[at as usize], (first, left));
            (at, left) = (parent, left ^ turned);
        }
        (first, opposite)
    }

    /// Makes the sets of both one. If they are one already, says whether it has both as `opposite` says.
    pub fn join(&mut self, a: u32, b: u32, opposite: bool) -> bool {
        let ((a, turned_a), (b, turned_b)) = (self.find(a), self.find(b));
        if a == b {
            return turned_a ^ turned_b == opposite;
        }
        self.parents[a.max(b) as usize] = (a.min(b), turned_a ^ turned_b ^ opposite);
        true
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn sets_know_their_first_and_who_is_opposite() {
        let mut sets = Sets::new(6);
        assert!(sets.join(5, 3, true) && sets.join(3, 4, true) && sets.join(4, 1, false));
        assert_eq!([0, 1, 2, 3, 4, 5].map(|n| sets.find(n)), {
            [(0, false), (1, false), (2, false), (1, true), (1, false), (1, false)]
        });
        assert!(sets.join(5, 1, false) && !sets.join(5, 1, true));
    }
}
