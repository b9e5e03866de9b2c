//! Who gets what of a time that does not suffice for all.

use core::cmp::Ordering;
use std::collections::BinaryHeap;

use super::rung::{RUNGS, Rung};

/// Share of the time that is used after something had to be taken away, and up to which something is given back: between
/// this and all of it nothing changes, so that quality does not flicker with the measured costs.
const LOWER_TO: f64 = 0.95;
const RAISE_TO: f64 = 0.9;
/// How many times more one cloth must miss a rung than others would, for these to make way.
const EXCHANGE: f64 = 3.0;
/// What the importance of a cloth is raised by that is lowered only if nothing else is left.
const LAST_RESORT: f64 = 1e9;

/// A cloth that wants time.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Request {
    /// Time per tick on each rung, s.
    pub costs: [f64; RUNGS],
    /// Larger is more.
    pub importance: f64,
    /// The rung asked for: never gone beyond.
    pub top: Rung,
    /// Where it stands.
    pub rung: Rung,
    /// Lowered only if nothing else is left.
    pub last_resort: bool,
}

impl Request {
    /// What is taken from the eye between two rungs, the first above the second. Each rung takes twice as much as the one
    /// above it.
    fn loss(&self, above: Rung, below: Rung) -> f64 {
        let importance = self.importance + if self.last_resort { LAST_RESORT } else { 0.0 };
        importance * ((1_u32 << below.0) - (1_u32 << above.0)) as f64
    }

    fn cost(&self) -> f64 {
        self.costs[self.rung.0]
    }

    /// The next rung down that costs less, what going there saves per tick, s, and what it takes from the eye.
    fn lower(&self) -> Option<Move> {
        let below = (self.rung.0 + 1..RUNGS).map(Rung).find(|below| self.costs[below.0] < self.cost())?;
        Some(Move { to: below, change: self.costs[below.0] - self.cost(), loss: self.loss(self.rung, below) })
    }

    /// The next rung up, if it was asked for.
    fn raise(&self) -> Option<Move> {
        let above = Rung(self.rung.0.checked_sub(1)?);
        (above >= self.top).then(|| Move {
            to: above,
            change: self.costs[above.0] - self.cost(),
            loss: self.loss(above, self.rung),
        })
    }
}

/// To another rung.
#[derive(Clone, Copy, Debug)]
struct Move {
    to: Rung,
    /// s per tick.
    change: f64,
    loss: f64,
}

/// A cloth in order of what it would lose, the least first out of a heap.
struct Loss(f64, usize);

impl Ord for Loss {
    fn cmp(&self, other: &Self) -> Ordering {
        other.0.total_cmp(&self.0).then(other.1.cmp(&self.1))
    }
}

impl PartialOrd for Loss {
    fn partial_cmp(&self, other: &Self) -> Option<Ordering> {
        Some(self.cmp(other))
    }
}

impl PartialEq for Loss {
    fn eq(&self, other: &Self) -> bool {
        self.cmp(other).is_eq()
    }
}

impl Eq for Loss {}

/// Time per tick that the cloths take where they stand, s.
pub(super) fn total(requests: &[Request]) -> f64 {
    requests.iter().map(Request::cost).sum()
}

/// Moves cloths so that they take no more than `capacity` (s per tick), the least loss first, as far as their ladders go; if
/// `may_raise`, gives back what there is time for, by one rung each, the greatest loss first.
pub(super) fn allocate(requests: &mut [Request], capacity: f64, may_raise: bool) {
    for request in &mut *requests {
        request.rung = request.rung.max(request.top);
    }
    let mut used = total(requests);
    if used > capacity {
        lower(requests, &mut used, LOWER_TO * capacity);
    } else if may_raise {
        raise(requests, &mut used, RAISE_TO * capacity);
    }
}

fn lower(requests: &mut [Request], used: &mut f64, limit: f64) {
    let next = |request: &Request, index| request.lower().map(|step| Loss(step.loss, index));
    let mut queue: BinaryHeap<_> = requests.iter().enumerate().filter_map(|(i, request)| next(request, i)).collect();
    while *used > limit
        && let Some(Loss(_, index)) = queue.pop()
    {
        let request = &mut requests[index];
        if let Some(step) = request.lower() {
            *used += step.change;
            request.rung = step.to;
            queue.extend(next(request, index));
        }
    }
}

fn raise(requests: &mut [Request], used: &mut f64, limit: f64) {
    let mut wanted: Vec<_> = requests.iter().enumerate().filter_map(|(i, r)| Some((r.raise()?, i))).collect();
    wanted.sort_unstable_by(|(a, i), (b, j)| b.loss.total_cmp(&a.loss).then(i.cmp(j)));
    let mut victims: Vec<_> = requests.iter().enumerate().filter_map(|(i, r)| Some((r.lower()?, i))).collect();
    victims.sort_unstable_by(|(a, i), (b, j)| a.loss.total_cmp(&b.loss).then(i.cmp(j)));
    let (mut moved, mut victims) = (vec![false; requests.len()], victims.into_iter().peekable());
    for (step, index) in wanted {
        if moved[index] {
            continue;
        }
        // Those who would lose far less make way.
        while *used + step.change > limit
            && let Some((other, victim)) =
                victims.next_if(|(other, victim)| EXCHANGE * other.loss < step.loss && *victim != index)
        {
            if !moved[victim] {
                moved[victim] = true;
                requests[victim].rung = other.to;
                *used += other.change;
            }
        }
        if *used + step.change <= limit {
            moved[index] = true;
            requests[index].rung = step.to;
            *used += step.change;
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Costs as a step of the default takes, s.
    fn request(default: f64, importance: f64) -> Request {
        let costs = [4.1, 2.0, 1.0, 0.48, 0.25, 0.14].map(|work| work * default);
        Request { costs, importance, top: Rung(2), rung: Rung(2), last_resort: false }
    }

    fn crowd() -> Vec<Request> {
        (0..100).map(|i| request(1e-4, 1.0 / f64::from(1 + i))).collect()
    }

    #[test]
    fn three_times_the_budget_is_cut_to_it_and_the_important_keep_their_level() {
        let mut cloths = crowd();
        let capacity = total(&cloths) / 3.0;
        allocate(&mut cloths, capacity, true);
        assert!((0.85..=1.0).contains(&(total(&cloths) / capacity)), "{}", total(&cloths) / capacity);
        assert_eq!(cloths[0].rung, Rung(2), "the most important");
        assert!(cloths.windows(2).all(|pair| pair[0].rung <= pair[1].rung), "by importance");
        assert_eq!(cloths[99].rung, Rung::LOWEST);
    }

    #[test]
    fn an_expensive_cloth_that_matters_is_not_the_first_to_pay() {
        let mut cloths = crowd();
        cloths.push(request(5e-3, 4.0));
        let capacity = 0.8 * total(&cloths);
        allocate(&mut cloths, capacity, true);
        assert_eq!(cloths[100].rung, Rung(2));
    }

    #[test]
    fn with_time_enough_everyone_gets_what_was_asked_for_and_no_more() {
        let mut cloths = crowd();
        cloths.iter_mut().for_each(|cloth| cloth.rung = Rung::LOWEST);
        for _ in 0..RUNGS {
            allocate(&mut cloths, 1.0, true);
        }
        assert!(cloths.iter().all(|cloth| cloth.rung == cloth.top));
        cloths[3].top = Rung(4);
        allocate(&mut cloths, 1.0, false);
        assert_eq!(cloths[3].rung, Rung(4), "asked for less");
    }

    #[test]
    fn costs_that_waver_change_nothing() {
        let mut cloths = crowd();
        let capacity = total(&cloths) / 3.0;
        for _ in 0..20 {
            allocate(&mut cloths, capacity, true);
        }
        let settled: Vec<_> = cloths.iter().map(|cloth| cloth.rung).collect();
        for round in 0..100 {
            let waver = 1.0 + 0.04 * (f64::from(round)).sin();
            let mut wavering = cloths.clone();
            wavering.iter_mut().for_each(|cloth| cloth.costs = cloth.costs.map(|cost| cost * waver));
            allocate(&mut wavering, capacity, true);
            let rungs: Vec<_> = wavering.iter().map(|cloth| cloth.rung).collect();
            assert_eq!(rungs, settled, "round {round}");
        }
    }

    #[test]
    fn who_becomes_important_takes_the_place_of_others() {
        let mut cloths = crowd();
        let capacity = total(&cloths) / 3.0;
        allocate(&mut cloths, capacity, true);
        assert_eq!(cloths[90].rung, Rung::LOWEST);
        cloths[90].importance = 10.0;
        for _ in 0..20 {
            allocate(&mut cloths, capacity, true);
            assert!(total(&cloths) <= capacity);
        }
        assert_eq!(cloths[90].rung, Rung(2));
    }

    #[test]
    fn settings_given_one_by_one_are_the_last_to_suffer() {
        let mut cloths = crowd();
        let own = |importance| Request {
            last_resort: true,
            top: Rung::EVERY_TICK,
            rung: Rung::EVERY_TICK,
            ..request(1e-4, importance)
        };
        cloths.extend([own(1e-3), own(0.0)]);
        let least: f64 = cloths[..100].iter().map(|cloth| cloth.costs[RUNGS - 1]).sum();
        allocate(&mut cloths, (least + 2.1e-4) / LOWER_TO, true);
        assert_eq!([cloths[100].rung, cloths[101].rung], [Rung::EVERY_TICK; 2]);
        allocate(&mut cloths, 0.0, true);
        assert!(cloths.iter().all(|cloth| cloth.rung == Rung::LOWEST));
    }
}
