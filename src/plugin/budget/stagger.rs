//! Which tick a cloth that is not stepped in every one is stepped in, so that all ticks have as much to do.

use super::rung::Rung;

/// Ticks after which everything repeats.
pub(super) const PERIOD: u32 = 1 << (Rung::LOWEST.0 - Rung::EVERY_TICK.0);
/// Share by which the fullest tick may exceed the mean before cloths are moved out of it.
const UNEVEN: f64 = 1.05;
/// Most moves of a round: each makes one step of a cloth longer or shorter.
const MOVES: usize = 8;

/// A cloth and its turn: a step in each tick whose number is `phase` modulo `interval`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Turn {
    /// Ticks from step to step.
    pub interval: u32,
    /// Below `interval`; `None` is to be chosen.
    pub phase: Option<u32>,
    /// Time of a step, s.
    pub cost: f64,
}

impl Turn {
    fn ticks(&self, phase: u32) -> impl Iterator<Item = usize> {
        (phase..PERIOD).step_by(self.interval as usize).map(|tick| tick as usize)
    }

    /// The phase whose fullest tick has the least to do, and what that is.
    fn emptiest(&self, load: &[f64]) -> (u32, f64) {
        let fullest = |phase| self.ticks(phase).map(|tick| load[tick]).fold(0.0, f64::max);
        let phases = (0..self.interval).map(|phase| (phase, fullest(phase)));
        phases.min_by(|(_, a), (_, b)| a.total_cmp(b)).unwrap_or_default()
    }
}

/// Chooses the phases that are to be chosen, and moves some of those that fill one tick more than others.
pub(super) fn stagger(turns: &mut [Turn]) {
    let mut load = [0.0; PERIOD as usize];
    let add = |load: &mut [f64], turn: &Turn, phase: u32, cost: f64| turn.ticks(phase).for_each(|t| load[t] += cost);
    for turn in &*turns {
        if let Some(phase) = turn.phase {
            add(&mut load, turn, phase, turn.cost);
        }
    }
    // Large ones first, as the small ones fill the gaps.
    let mut new: Vec<_> = (0..turns.len()).filter(|&i| turns[i].phase.is_none()).collect();
    new.sort_by(|&a, &b| turns[b].cost.total_cmp(&turns[a].cost));
    for index in new {
        let turn = &mut turns[index];
        let (phase, _) = turn.emptiest(&load);
        turn.phase = Some(phase);
        add(&mut load, turn, phase, turn.cost);
    }
    for _ in 0..MOVES {
        let mean = load.iter().sum::<f64>() / f64::from(PERIOD);
        let Some((full, &most)) = load.iter().enumerate().max_by(|(_, a), (_, b)| a.total_cmp(b)) else { break };
        if most <= UNEVEN * mean {
            break;
        }
        // The one whose move evens out the most.
        let relief = |turn: &Turn| {
            let phase = turn.phase.filter(|_| turn.interval > 1)?;
            let there = full as u32 % turn.interval == phase;
            let (to, filled) = turn.emptiest(&load);
            let left = (most - turn.cost).max(filled + turn.cost);
            (there && to != phase && left < most).then_some((to, left))
        };
        let moves = turns.iter().enumerate().filter_map(|(i, turn)| Some((i, relief(turn)?)));
        let Some((index, (to, _))) = moves.min_by(|(_, (_, a)), (_, (_, b))| a.total_cmp(b)) else { break };
        let turn = &mut turns[index];
        if let Some(from) = turn.phase.replace(to) {
            add(&mut load, turn, from, -turn.cost);
            add(&mut load, turn, to, turn.cost);
        }
    }
}

/// Ticks from the step of tick `now`, which came `span` after the one before, to the next: that of the turn, but no sooner than
/// after half of `span`, as what moved in `span` ticks is shown in that time.
pub(in crate::plugin) fn following(now: u32, interval: u32, phase: u32, span: u32) -> u32 {
    let wait = (phase + interval - now % interval) % interval;
    let least = span.div_ceil(2).max(1);
    wait + least.saturating_sub(wait).div_ceil(interval) * interval
}

#[cfg(test)]
mod tests {
    use super::*;

    fn loads(turns: &[Turn]) -> Vec<f64> {
        let due = |tick: u32| turns.iter().filter(move |turn| Some(tick % turn.interval) == turn.phase);
        (0..PERIOD).map(|tick| due(tick).map(|turn| turn.cost).sum()).collect()
    }

    fn spread(turns: &[Turn]) -> f64 {
        let loads = loads(turns);
        loads.iter().copied().fold(0.0, f64::max) / (loads.iter().sum::<f64>() / loads.len() as f64)
    }

    fn mixed() -> Vec<Turn> {
        let interval = |i: usize| [1, 2, 4, 8][i % 4];
        (0..200).map(|i| Turn { interval: interval(i), phase: None, cost: 1.0 + (i % 7) as f64 }).collect()
    }

    #[test]
    fn all_ticks_have_as_much_to_do() {
        let mut turns = mixed();
        stagger(&mut turns);
        assert!(spread(&turns) < 1.03, "{:?}", loads(&turns));
        assert!(turns.iter().all(|turn| turn.phase.is_some_and(|phase| phase < turn.interval)));
    }

    #[test]
    fn those_in_step_stay_there() {
        let mut turns = mixed();
        stagger(&mut turns);
        let before = turns.clone();
        stagger(&mut turns);
        assert_eq!(turns, before);
    }

    #[test]
    fn a_full_tick_is_emptied_a_few_at_a_time() {
        let mut turns = vec![Turn { interval: 8, phase: Some(3), cost: 1.0 }; 80];
        stagger(&mut turns);
        assert_eq!(turns.iter().filter(|turn| turn.phase != Some(3)).count(), MOVES);
        for _ in 0..10 {
            stagger(&mut turns);
        }
        assert!(spread(&turns) < 1.11, "{:?}", loads(&turns));
    }

    #[test]
    fn the_next_step_is_in_turn_and_not_too_soon() {
        // In step: after the interval.
        assert_eq!(following(12, 4, 0, 4), 4);
        assert_eq!(following(13, 1, 0, 1), 1);
        // Out of step: when it is its turn, if half of the last span has passed by then.
        assert_eq!(following(13, 4, 0, 4), 3);
        assert_eq!(following(15, 4, 0, 4), 5);
        assert_eq!(following(15, 4, 0, 1), 1);
        // To every tick, there and gradually.
        assert_eq!([8, 4, 2].map(|span| following(5, 1, 0, span)), [4, 2, 1]);
        for (now, phase) in (0..16).flat_map(|now| (0..8).map(move |phase| (now, phase))) {
            let wait = following(now, 8, phase, 8);
            assert!((now + wait) % 8 == phase && (4..12).contains(&wait));
        }
    }
}
