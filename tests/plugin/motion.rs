//! Cloth on what is moved in any schedule, at any rate of frames: found by capes that shook by decimeters at Bevy's default rates.

use bevy::app::{FixedFirst, FixedPostUpdate};
use bevy::math::DVec3;
use bevy::prelude::*;
use bevy_cloth::plugin::*;

use crate::common::*;
use crate::stage::*;

/// Shake of what is drawn (root mean square of its second difference in the frame of the wearer, mm) and largest stretch in %.
#[derive(Clone, Copy, Debug)]
struct Shake {
    rms: f64,
    stretch: f64,
}

impl Shake {
    fn of(app: &mut App, cloth: Entity, frames: impl Iterator<Item = f64>) -> Self {
        let (mut before, mut sum, mut count, mut worst) = (Vec::<Vec<Vec3>>::new(), 0.0, 0, Worst::default());
        for seconds in frames {
            frame(app, seconds);
            worst.look(app, cloth, Vec3::ZERO);
            before.push(local(app, cloth));
            if let [.., a, b, c] = &before[..] {
                let differences = a.iter().zip(b).zip(c).map(|((a, b), c)| (*a - 2.0 * *b + *c).length_squared());
                sum += differences.map(f64::from).sum::<f64>();
                count += a.len();
            }
        }
        Self { rms: 1e3 * (sum / f64::from(count as u32)).sqrt(), stretch: 100.0 * worst.stretch }
    }

    #[track_caller]
    fn assert_as_calm_as(self, fixed: Self, case: &str) {
        assert!(self.rms <= 1.5 * fixed.rms + 0.1, "{case}: shakes by {self:?}, moved in FixedUpdate by {fixed:?}");
        assert!(self.stretch <= fixed.stretch + 1.0, "{case}: {self:?}, moved in FixedUpdate {fixed:?}");
    }
}

fn runs(t: f32) -> Transform {
    Transform::from_xyz(6.0 * t, 1.0, 0.0)
}

fn sways(t: f32) -> Transform {
    runs(t).with_rotation(Quat::from_rotation_y(0.5 * (core::f32::consts::TAU * t).sin()))
}

/// A cape on something that is moved so. Nothing is touched: contact makes much of little, so that capes with a body are judged by the
/// worst of several starts, in the laboratory.
fn worn(app: &mut App, moved: fn(f32) -> Transform) -> Entity {
    let t = app.world().resource::<Time>().elapsed_secs();
    let wearer = app.world_mut().spawn((moved(t), Moved(moved))).id();
    spawn(app, cape(10, 0.0), (collar(), ChildOf(wearer)))
}

fn shake_of(hz: f64, mover: Mover, moved: fn(f32) -> Transform, lengths: &[f64]) -> Shake {
    let mut app = app_at(hz, mover);
    let cloth = worn(&mut app, moved);
    let all = || lengths.iter().copied().cycle();
    let seconds = |from: f64, to: f64| {
        all()
            .scan(0.0, |t, length| {
                *t += length;
                Some((*t, length))
            })
            .skip_while(move |(t, _)| *t < from)
            .take_while(move |(t, _)| *t < to)
            .map(|(_, length)| length)
    };
    for length in seconds(0.0, 2.5) {
        frame(&mut app, length);
    }
    Shake::of(&mut app, cloth, seconds(2.5, 4.0))
}

#[test]
fn a_cape_is_as_calm_on_what_update_or_animation_moves_as_on_what_ticks_move() {
    for (hz, fps) in [(64.0, 30.0), (64.0, 60.0), (64.0, 75.0), (64.0, 144.0), (60.0, 60.0), (60.0, 59.94)] {
        for moved in [runs as fn(f32) -> Transform, sways] {
            let [fixed, update, animated] = Mover::ALL.map(|mover| shake_of(hz, mover, moved, &[1.0 / fps]));
            update.assert_as_calm_as(fixed, &format!("{hz} Hz, {fps} frames a second, Update"));
            animated.assert_as_calm_as(fixed, &format!("{hz} Hz, {fps} frames a second, animation"));
        }
    }
}

#[test]
fn uneven_frames_shake_no_more() {
    let jitter: Vec<f64> = (0..97).map(|i| 1.0 / 60.0 + 3e-3 * (f64::from(i * 37 % 97) / 48.0 - 1.0)).collect();
    for (case, lengths) in [("jitter", &jitter[..]), ("14 and 19 ms", &[0.014, 0.019])] {
        let [fixed, update, animated] = Mover::ALL.map(|mover| shake_of(64.0, mover, runs, lengths));
        update.assert_as_calm_as(fixed, case);
        animated.assert_as_calm_as(fixed, case);
    }
}

/// A bone that is animated on a body that ticks move, and the reverse.
#[test]
fn each_of_a_hierarchy_may_be_moved_elsewhere() {
    let bone = |t: f32| Transform::from_rotation(Quat::from_rotation_y(0.5 * (core::f32::consts::TAU * t).sin()));
    let shake = |root_in: Mover, bone_in: Mover| {
        #[derive(Component)]
        struct Bone(fn(f32) -> Transform);
        let turn = |time: Res<Time>, mut bones: Query<(&Bone, &mut Transform)>| {
            for (bone, mut transform) in &mut bones {
                *transform = (bone.0)(time.elapsed_secs());
            }
        };
        let mut app = app_at(64.0, root_in);
        match bone_in {
            Mover::FixedUpdate => app.add_systems(FixedUpdate, turn.before(ClothSystems::Collect)),
            Mover::Update => app.add_systems(Update, turn),
            Mover::PostUpdate => app.add_systems(PostUpdate, turn.before(TransformSystems::Propagate)),
        };
        let root = app.world_mut().spawn((runs(0.0), Moved(runs))).id();
        let bone = app.world_mut().spawn((Transform::IDENTITY, Bone(bone), ChildOf(root))).id();
        let cloth = spawn(&mut app, cape(10, 0.0), (collar(), ChildOf(bone)));
        for _ in 0..150 {
            frame(&mut app, 1.0 / 60.0);
        }
        Shake::of(&mut app, cloth, core::iter::repeat_n(1.0 / 60.0, 90))
    };
    let fixed = shake(Mover::FixedUpdate, Mover::FixedUpdate);
    for root in Mover::ALL {
        for bone in Mover::ALL {
            shake(root, bone).assert_as_calm_as(fixed, &format!("root in {root:?}, bone in {bone:?}"));
        }
    }
}

/// Physics engines ease what ticks move, for the eye: that is no motion.
#[test]
fn what_is_eased_between_ticks_is_where_the_ticks_put_it() {
    #[derive(Component, Default)]
    struct Eased(Transform, Transform);
    let back = |mut eased: Query<(&Eased, &mut Transform)>| eased.iter_mut().for_each(|(e, mut t)| *t = e.1);
    let step = |time: Res<Time>, mut eased: Query<(&mut Eased, &mut Transform)>| {
        for (mut eased, mut transform) in &mut eased {
            eased.0 = eased.1;
            *transform = runs(time.elapsed_secs());
            eased.1 = *transform;
        }
    };
    let ease = |fixed: Res<Time<Fixed>>, mut eased: Query<(&Eased, &mut Transform)>| {
        for (eased, mut transform) in &mut eased {
            transform.translation = eased.0.translation.lerp(eased.1.translation, fixed.overstep_fraction());
        }
    };
    for fps in [30.0, 60.0, 144.0] {
        let mut app = app_at(64.0, Mover::Update);
        app.add_systems(FixedFirst, back)
            .add_systems(FixedPostUpdate, step)
            .add_systems(RunFixedMainLoop, ease.in_set(RunFixedMainLoopSystems::AfterFixedMainLoop));
        let eased = Eased(runs(0.0), runs(0.0));
        let wearer = app.world_mut().spawn((runs(0.0), eased)).id();
        let cloth = spawn(&mut app, cape(10, 0.0), (collar(), ChildOf(wearer)));
        for _ in 0..(2.5 * fps) as usize {
            frame(&mut app, 1.0 / fps);
        }
        let shake = Shake::of(&mut app, cloth, core::iter::repeat_n(1.0 / fps, (1.5 * fps) as usize));
        shake.assert_as_calm_as(shake_of(64.0, Mover::FixedUpdate, runs, &[1.0 / fps]), &format!("{fps}"));
    }
}

/// A collider and a pin that move together are always seen together.
#[test]
fn pins_and_colliders_are_seen_at_the_same_time() {
    #[derive(Resource, Default)]
    struct Off(f64);
    for mover in Mover::ALL {
        let mut app = app_at(64.0, mover);
        let wearer = app.world_mut().spawn((runs(0.0), Moved(runs))).id();
        app.world_mut().spawn((ClothCollider::sphere(0.3), ChildOf(wearer)));
        spawn(&mut app, cape(4, 0.3), (ClothPins::indices([0]), ChildOf(wearer)));
        app.init_resource::<Off>().add_systems(
            FixedUpdate,
            (|cloths: Query<&ClothState>, mut off: ResMut<Off>| {
                let cloth = cloths.single().unwrap().cloth();
                let Some(collider) = cloth.colliders().first() else { return };
                let pin: DVec3 = cloth.pin_target(0).unwrap();
                off.0 = off.0.max((pin - collider.end.translation - DVec3::new(-0.4, 0.0, 0.3)).length());
            })
            .after(ClothSystems::Collect)
            .before(ClothSystems::Step),
        );
        for i in 0..120 {
            frame(&mut app, [1.0 / 60.0, 0.011, 0.021][i % 3]);
        }
        assert!(app.world().resource::<Off>().0 < 1e-5, "{mover:?}: {} m", app.world().resource::<Off>().0);
    }
}

#[test]
fn pin_targets_may_be_moved_once_a_frame() {
    let drag = |mover: Mover| {
        let mut app = app_at(64.0, Mover::FixedUpdate);
        let grab = |time: Res<Time>, mut targets: Query<&mut ClothPinTargets>| {
            let x = 1.5 * time.elapsed_secs();
            targets.single_mut().unwrap().0 =
                [(0, Vec3::new(x - 0.4, 0.0, 0.0)), (10, Vec3::new(x + 0.4, 0.0, 0.0))].into();
        };
        match mover {
            Mover::FixedUpdate => app.add_systems(FixedUpdate, grab.before(ClothSystems::Collect)),
            _ => app.add_systems(Update, grab),
        };
        let cloth = spawn(&mut app, cape(10, 0.0), ClothPinTargets::default());
        let mut worst = Worst::default();
        for i in 0..180 {
            frame(&mut app, 1.0 / 60.0);
            if i > 90 {
                worst.look(&app, cloth, Vec3::X * 1.5);
            }
        }
        worst
    };
    let [fixed, update] = [Mover::FixedUpdate, Mover::Update].map(drag);
    assert!(update.speed <= 1.5 * fixed.speed + 0.05 && update.stretch <= fixed.stretch + 0.01, "{update:?} {fixed:?}");
}
