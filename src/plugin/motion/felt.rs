//! What of the motion of its entity a cloth feels.
//!
//! The motion M of the entity in a tick is split into M = F P. P carries the cloth as it is, with its history; then the pins drag it by F.
//! Most motions are felt wholly: then P is the identity. The split depends on the speed of the held vertices, so that a turn counts by
//! how far it swings them. It depends on changes of speed only, so that neither a steady speed of the whole world nor the length of a
//! tick matters.

use bevy::math::{DAffine3, DMat3, DQuat, DVec3};

/// Time after which a jump in speed that lasts is a speed, s: dashes of games take up to a quarter of a second.
const LASTS: f64 = 0.3;

/// Jumps of an entity that nothing is held by, over those of one that holds cloth: no cloth is dragged, so only what is surely no motion
/// counts. Half a meter in a frame of 1/60 s.
const FREE: f64 = 3.0;

/// See [`ClothInertia`](crate::plugin::ClothInertia).
#[derive(Clone, Copy, Debug, PartialEq)]
pub(in crate::plugin) struct Limits {
    /// Shares of the motion.
    pub linear: f64,
    pub angular: f64,
    /// m/s and rad/s.
    pub max_speed: f64,
    pub max_turn: f64,
    /// m/s².
    pub max_acceleration: f64,
    /// m/s.
    pub jump_speed: f64,
}

/// The velocity of its entity as a cloth feels it.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
#[cfg_attr(feature = "serialize", derive(serde::Serialize, serde::Deserialize))]
pub(in crate::plugin) struct Felt {
    /// Of the middle of what is held, m/s, and rad/s.
    velocity: DVec3,
    turn: DVec3,
    /// The velocity if it turned with the entity in a jump: only the next tick shows whether it did.
    turned: Option<DVec3>,
    /// How long a jump in speed has lasted, s.
    lasted: f64,
    /// Velocity of the entity in the last tick, m/s.
    last: DVec3,
}

/// A rigid motion in a tick.
#[derive(Clone, Copy, Debug)]
pub(in crate::plugin) struct Motion {
    /// About this point, m.
    middle: DVec3,
    /// m/s.
    velocity: DVec3,
    /// In the whole tick.
    rotation: DQuat,
    /// s.
    dt: f64,
}

/// What a cloth does not feel.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(in crate::plugin) struct Carry {
    /// P.
    pub map: DAffine3,
    /// Velocity that all vertices get beyond what P turns, m/s.
    pub boost: DVec3,
    /// Velocity of the entity that the cloth does not feel, but the air does, m/s.
    pub unfelt: DVec3,
    /// Whether this is a jump: what does not jump along has not moved against the cloth.
    pub jumped: bool,
}

impl Carry {
    pub const NOTHING: Self = Self { map: DAffine3::IDENTITY, boost: DVec3::ZERO, unfelt: DVec3::ZERO, jumped: false };
}

impl Motion {
    /// The motion from one transform to another of the same scale, about a point that is `middle` at first.
    pub fn between(before: DAffine3, now: DAffine3, middle: DVec3, dt: f64) -> Self {
        let velocity = (now.transform_point3(before.inverse().transform_point3(middle)) - middle) / dt;
        let rotation = if before.matrix3 == now.matrix3 {
            DQuat::IDENTITY
        } else {
            rotation_of(now.matrix3 * before.matrix3.inverse())
        };
        Self { middle, velocity, rotation, dt }
    }

    fn of(velocity: DVec3, turn: DVec3, middle: DVec3, dt: f64) -> Self {
        Self { middle, velocity, rotation: DQuat::from_scaled_axis(turn * dt), dt }
    }

    /// rad/s.
    fn turn(&self) -> DVec3 {
        self.rotation.to_scaled_axis() / self.dt
    }

    fn affine(&self) -> DAffine3 {
        let rotation = DMat3::from_quat(self.rotation);
        let translation = self.middle + self.velocity * self.dt - rotation * self.middle;
        DAffine3 { matrix3: rotation, translation }
    }

    /// How much faster another motion moves some of these points, at most, m/s.
    fn deviation(&self, other: &Self, points: &[DVec3]) -> f64 {
        let apart = |p: &DVec3| {
            let arm = *p - self.middle;
            (self.velocity - other.velocity + (self.rotation * arm - other.rotation * arm) / self.dt).length_squared()
        };
        points.iter().map(apart).fold(0.0, f64::max).sqrt()
    }
}

/// The rotation of a linear map that is one but for rounding.
fn rotation_of(map: DMat3) -> DQuat {
    let x = map.x_axis.normalize_or(DVec3::X);
    let y = map.y_axis.reject_from_normalized(x).normalize_or(x.any_orthonormal_vector());
    DQuat::from_mat3(&DMat3::from_cols(x, y, x.cross(y))).normalize()
}

impl Felt {
    /// Feels the motion of a tick, by what is held at `points`.
    pub fn feel(&mut self, motion: &Motion, points: &[DVec3], limits: &Limits) -> Carry {
        let Motion { middle, velocity, dt, .. } = *motion;
        let felt = |velocity, turn| Motion::of(velocity, turn, middle, dt);
        let mut carry = Carry::NOTHING;
        let mut deviation = motion.deviation(&felt(self.velocity, self.turn), points);
        if let Some(turned) = self.turned {
            let other = motion.deviation(&felt(turned, self.turn), points);
            if other < deviation {
                carry.boost = turned - self.velocity;
                (self.velocity, deviation) = (turned, other);
            }
        }
        let gentle = limits.max_acceleration * dt;
        let same = velocity.distance(self.last) <= limits.jump_speed;
        self.lasted = if deviation > gentle && same { self.lasted } else { 0.0 };
        self.last = velocity;
        if deviation <= gentle {
            (self.velocity, self.turn, self.turned) = (velocity, motion.turn(), None);
        } else if deviation > limits.jump_speed && self.lasted < LASTS {
            carry.jumped = true;
            self.lasted += dt;
        } else {
            self.turned = None;
            if self.lasted >= LASTS {
                // The cloth has been carried at that speed for long: it has it.
                carry.boost += velocity - self.velocity;
                self.velocity = velocity;
                deviation = motion.deviation(&felt(self.velocity, self.turn), points);
            }
            let share = (gentle / deviation.max(f64::MIN_POSITIVE)).min(1.0);
            self.velocity += share * (velocity - self.velocity);
            self.turn += share * (motion.turn() - self.turn);
        }
        let slowed = limits.linear * self.velocity.clamp_length_max(limits.max_speed);
        let steadied = limits.angular * self.turn.clamp_length_max(limits.max_turn);
        carry.unfelt = self.velocity - slowed;
        let whole = deviation <= gentle && slowed == self.velocity && steadied == self.turn;
        if !whole {
            // About where the middle is once it was carried.
            let about = middle + (velocity - slowed) * dt;
            carry.map = Motion::of(slowed, steadied, about, dt).affine().inverse() * motion.affine();
            let rotation = rotation_of(carry.map.matrix3);
            // Folds turn along; the speed of the whole stays as it was until it is seen to have turned.
            let mean = slowed;
            carry.boost += mean - rotation * mean;
            if carry.jumped {
                self.turned = Some(rotation * self.turned.unwrap_or(self.velocity));
            }
        }
        carry
    }

    /// Whether a motion is a jump of something that does not follow its entity otherwise.
    pub fn jumps(&mut self, motion: &Motion, points: &[DVec3], limits: &Limits) -> bool {
        let before = Motion::of(self.velocity, self.turn, motion.middle, motion.dt);
        (self.velocity, self.turn) = (motion.velocity, motion.turn());
        motion.deviation(&before, points) > FREE * limits.jump_speed
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const LIMITS: Limits = Limits {
        linear: 1.0,
        angular: 1.0,
        max_speed: f64::INFINITY,
        max_turn: f64::INFINITY,
        max_acceleration: 100.0,
        jump_speed: 8.0,
    };
    const DT: f64 = 1.0 / 60.0;

    /// A bar of 1 m that is held at both ends, 25 cm behind the axis.
    const ENDS: [DVec3; 2] = [DVec3::new(-0.5, 0.0, 0.25), DVec3::new(0.5, 0.0, 0.25)];

    struct Wearer {
        felt: Felt,
        at: DAffine3,
        limits: Limits,
    }

    impl Wearer {
        fn new(limits: Limits) -> Self {
            Self { felt: Felt::default(), at: DAffine3::IDENTITY, limits }
        }

        fn go(&mut self, to: DAffine3) -> Carry {
            let points = ENDS.map(|p| self.at.transform_point3(p));
            let motion = Motion::between(self.at, to, 0.5 * (points[0] + points[1]), DT);
            self.at = to;
            self.felt.feel(&motion, &points, &self.limits)
        }

        fn run(&mut self, velocity: DVec3) -> Carry {
            self.go(DAffine3::from_translation(velocity * DT) * self.at)
        }
    }

    #[test]
    fn ordinary_motion_is_felt_wholly() {
        let mut wearer = Wearer::new(LIMITS);
        for i in 0..600 {
            let speed = 0.5 * f64::from(i).min(12.0);
            let there = wearer.at * DAffine3::from_rotation_y(0.02);
            assert_eq!(wearer.go(DAffine3::from_translation(DVec3::X * speed * DT) * there), Carry::NOTHING);
        }
    }

    #[test]
    fn a_teleport_is_carried_wholly_at_rest_and_on_the_run() {
        for speed in [0.0, 6.0] {
            let run = DVec3::Z * speed;
            let mut wearer = Wearer::new(LIMITS);
            for _ in 0..10 {
                wearer.run(run);
            }
            let there = wearer.at.translation + DVec3::X * 50.0 + run * DT;
            let carry = wearer.go(DAffine3 { translation: there, ..wearer.at });
            assert!(carry.jumped && carry.boost == DVec3::ZERO);
            assert!(carry.map.translation.distance(DVec3::X * 50.0) < 1e-9, "{carry:?}");
            assert_eq!(wearer.run(run), Carry::NOTHING);
        }
    }

    #[test]
    fn facing_about_turns_the_cloth_and_the_run_only_if_that_turns_too() {
        for (after, boost) in [(6.0, 0.0), (-6.0, 12.0)] {
            let mut wearer = Wearer::new(LIMITS);
            for _ in 0..60 {
                wearer.run(DVec3::Z * 6.0);
            }
            let there = wearer.at.translation + DVec3::Z * after * DT;
            let carry = wearer.go(DAffine3 { translation: there, ..DAffine3::from_rotation_y(3.1) });
            let velocity = carry.map.matrix3 * (DVec3::Z * 6.0) + carry.boost;
            assert!(carry.jumped && velocity.distance(DVec3::Z * 6.0) < 0.5, "{carry:?}");
            let next = wearer.run(DVec3::Z * after);
            assert!(!next.jumped && (next.boost.length() - boost).abs() < 0.6, "{after}: {next:?}");
        }
    }

    #[test]
    fn a_dash_is_carried_and_a_speed_that_lasts_is_taken_over() {
        let mut wearer = Wearer::new(LIMITS);
        for _ in 0..10 {
            assert!(wearer.run(DVec3::X * 60.0).jumped);
        }
        assert_eq!(wearer.run(DVec3::ZERO), Carry::NOTHING);
        let carried: Vec<_> = (0..60).map(|_| wearer.run(DVec3::X * 60.0)).collect();
        let boosts: DVec3 = carried.iter().map(|carry| carry.boost).sum();
        assert!((boosts - DVec3::X * 60.0).length() < 1e-9, "{boosts}");
        assert!(carried[..18].iter().all(|carry| carry.jumped) && carried[20..].iter().all(|c| *c == Carry::NOTHING));
    }

    #[test]
    fn a_sudden_start_is_felt_as_an_acceleration() {
        let mut wearer = Wearer::new(LIMITS);
        let mut ticks = 0;
        while wearer.run(DVec3::X * 7.0) != Carry::NOTHING {
            ticks += 1;
        }
        assert!((4..=5).contains(&ticks), "7 m/s at 100 m/s² take 70 ms: {ticks}");
    }

    #[test]
    fn shares_and_limits_carry_the_rest_and_tell_the_air() {
        let limits = Limits { linear: 0.5, max_speed: 4.0, ..LIMITS };
        let mut wearer = Wearer::new(limits);
        for _ in 0..30 {
            wearer.run(DVec3::X * 2.0);
        }
        let carry = wearer.run(DVec3::X * 2.0);
        assert!(carry.map.translation.distance(DVec3::X * DT) < 1e-12 && carry.unfelt.distance(DVec3::X) < 1e-12);
        for _ in 0..60 {
            wearer.run(DVec3::X * 10.0);
        }
        let carry = wearer.run(DVec3::X * 10.0);
        assert!(carry.map.translation.distance(DVec3::X * 8.0 * DT) < 1e-12, "{carry:?}");
        assert!(carry.boost.length() < 1e-12);
    }

    #[test]
    fn nothing_depends_on_the_speed_of_the_world() {
        let motions = |train: DVec3| {
            let mut wearer = Wearer::new(LIMITS);
            for _ in 0..60 {
                wearer.run(train);
            }
            let speeds = [3.0, 7.0, 7.0, 0.0, 20.0, 1.0, 0.0];
            speeds.map(|speed| wearer.run(train + DVec3::X * speed))
        };
        for (a, b) in motions(DVec3::ZERO).iter().zip(&motions(DVec3::Z * 40.0)) {
            assert!(a.jumped == b.jumped && a.map.translation.distance(b.map.translation) < 1e-9, "{a:?} {b:?}");
        }
    }
}
