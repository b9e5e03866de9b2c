//! What a game does to things between two frames: moves them while time stands, freezes them, hangs them elsewhere, shifts the
//! origin of everything.

use bevy::math::DVec3;
use bevy::prelude::*;
use bevy_cloth::plugin::{ClothCollider, ClothDisabled, ClothPinTargets, ClothPins};

use super::frames::Frames;
use super::jump::{HZ, SPEED, STRETCH, worst};
use super::stage::{Seen, Stage, sheet, top_edge};
use crate::row::Row;

/// How long it is calm before, and watched after, s.
const CALM: f64 = 3.0;
const SECONDS: f64 = 2.0;
/// Frames that time stands for, or the cloth is frozen.
const PAUSE: u32 = 20;
/// Height of what a free sheet lies on, m.
const TOP: f32 = 0.5;

/// A cloth, and what it hangs on or lies on.
struct Scene {
    stage: Stage,
    root: Entity,
    cloth: Entity,
}

/// An event.
#[derive(Clone, Copy, Debug)]
enum Event {
    /// Moved by so much while time stands, m.
    Paused(f32),
    /// The same with the parent.
    ParentPaused(f32),
    /// Turned by so many degrees while time stands.
    TurnedPaused(f32),
    /// Moved by so much while disabled, m.
    Disabled(f32),
    /// Moved by so much between two frames, all that there is, m: a cape.
    ShiftCape(f32),
    /// The same with a sheet that lies on a box.
    ShiftBox(f32),
    /// The same with a sheet that lies on ground.
    ShiftGround(f32),
    /// Hung on a parent that is elsewhere and turned, at its own place in it.
    Reparent,
    /// The same, keeping its place in the world.
    ReparentInPlace,
    /// Held at the opposite edge instead.
    OtherEdge,
    /// A sheet that lies on a box, 2 m below where it began, is held again at its edge.
    PinAgain,
    /// The middle of the hem is held near the top edge at once, nearly 1 m from where it hangs.
    Target,
}

const EVENTS: [Event; 21] = [
    Event::Paused(0.3),
    Event::Paused(1.0),
    Event::Paused(50.0),
    Event::ParentPaused(0.5),
    Event::TurnedPaused(180.0),
    Event::Disabled(0.3),
    Event::Disabled(1.0),
    Event::Disabled(50.0),
    Event::ShiftCape(1.5),
    Event::ShiftCape(3.0),
    Event::ShiftCape(1000.0),
    Event::ShiftBox(1.5),
    Event::ShiftBox(3.0),
    Event::ShiftBox(1000.0),
    Event::ShiftGround(1.5),
    Event::ShiftGround(1000.0),
    Event::Reparent,
    Event::ReparentInPlace,
    Event::OtherEdge,
    Event::PinAgain,
    Event::Target,
];

/// A look at all events.
const QUICK: [Event; 4] = [Event::Paused(1.0), Event::Disabled(1.0), Event::ShiftBox(3.0), Event::ReparentInPlace];

impl Event {
    fn name(self) -> String {
        match self {
            Self::Paused(distance) => format!("cape, moved by {distance} m while time stands"),
            Self::ParentPaused(distance) => format!("cape, parent moved by {distance} m while time stands"),
            Self::TurnedPaused(degrees) => format!("cape, turned by {degrees}° while time stands"),
            Self::Disabled(distance) => format!("cape, moved by {distance} m while disabled"),
            Self::ShiftCape(distance) => format!("cape, all moved by {distance} m"),
            Self::ShiftBox(distance) => format!("sheet on a box, all moved by {distance} m"),
            Self::ShiftGround(distance) => format!("sheet on ground, all moved by {distance} m"),
            Self::Reparent => "cape, hung on another parent".into(),
            Self::ReparentInPlace => "cape, hung on another parent in place".into(),
            Self::OtherEdge => "cape, held at its other edge".into(),
            Self::PinAgain => "sheet on a box, held again 2 m above".into(),
            Self::Target => "cape, hem held near the top".into(),
        }
    }

    fn scene(self, fps: f64) -> Scene {
        let mut stage = Stage::new(HZ, Frames::Even(fps), CALM, 0);
        let flat = Quat::from_rotation_x(-core::f32::consts::FRAC_PI_2);
        let (side, cells) = (0.8, 14);
        match self {
            Self::ShiftBox(_) | Self::ShiftGround(_) | Self::PinAgain => {
                let (collider, height) = match self {
                    Self::ShiftGround(_) => (ClothCollider::half_space(Dir3::Y), TOP),
                    _ => (ClothCollider::cuboid(0.6, 0.4, 0.6), TOP - 0.2),
                };
                let root = stage.spawn((collider, Transform::from_xyz(0.0, height, 0.0)), None);
                let above = if matches!(self, Self::PinAgain) { 2.0 } else { 0.05 };
                let transform = Transform::from_xyz(0.02, TOP + above, -0.4).with_rotation(flat);
                let cloth = stage.spawn_cloth(sheet(side, side, cells), transform, None);
                Scene { stage, root, cloth }
            }
            _ => {
                let root = stage.spawn(Transform::IDENTITY, None);
                let behind = Transform::from_xyz(0.0, 1.4, 0.25);
                let cloth = stage.spawn_cloth(sheet(side, side, cells), (top_edge(), behind), Some(root));
                Scene { stage, root, cloth }
            }
        }
    }

    fn happen(self, Scene { stage, root, cloth }: &mut Scene) {
        let (root, cloth) = (*root, *cloth);
        match self {
            Self::Paused(_) | Self::ParentPaused(_) | Self::TurnedPaused(_) => {
                stage.pause_for(PAUSE);
                let what = if matches!(self, Self::ParentPaused(_)) { root } else { cloth };
                let mut transform = stage.world().get_mut::<Transform>(what).expect("it has one");
                match self {
                    Self::TurnedPaused(degrees) => transform.rotate_around(Vec3::ZERO, turn(degrees)),
                    Self::Paused(distance) | Self::ParentPaused(distance) => transform.translation.x += distance,
                    _ => {}
                }
                stage.pause_for(PAUSE);
                stage.unpause();
            }
            Self::Disabled(distance) => {
                stage.world().entity_mut(cloth).insert(ClothDisabled);
                (0..PAUSE).for_each(|_| stage.frame());
                stage.world().get_mut::<Transform>(cloth).expect("it has one").translation.x += distance;
                (0..PAUSE).for_each(|_| stage.frame());
                stage.world().entity_mut(cloth).remove::<ClothDisabled>();
            }
            Self::ShiftCape(distance) | Self::ShiftBox(distance) | Self::ShiftGround(distance) => {
                let mut roots = stage.world().query_filtered::<&mut Transform, Without<ChildOf>>();
                for mut transform in roots.iter_mut(stage.world()) {
                    transform.translation += shift(distance);
                }
            }
            Self::Reparent | Self::ReparentInPlace => {
                let place = Transform::from_xyz(5.0, 0.0, 0.0).with_rotation(turn(90.0));
                let parent = stage.spawn(place, None);
                if matches!(self, Self::ReparentInPlace) {
                    let local = *stage.place(cloth);
                    let local = local.reparented_to(&GlobalTransform::from(place));
                    stage.world().entity_mut(cloth).insert(local);
                }
                stage.world().entity_mut(cloth).insert(ChildOf(parent));
            }
            Self::OtherEdge => {
                let hem = ClothPins::where_position(|p| p.y < -0.8 + 1e-4);
                stage.world().entity_mut(cloth).insert(hem);
            }
            Self::PinAgain => {
                stage.world().entity_mut(cloth).insert(top_edge());
            }
            Self::Target => {
                let hem = stage.drawn(cloth).iter().enumerate().filter(|(_, p)| p[0].abs() < 0.03);
                let lowest = hem.min_by(|a, b| a.1[1].total_cmp(&b.1[1])).map(|(vertex, _)| vertex as u32);
                let targets = [(lowest.expect("there is a hem"), Vec3::new(0.0, -0.05, 0.1))];
                stage.world().entity_mut(cloth).insert(ClothPinTargets(targets.into()));
            }
        }
    }

    /// What is seen, and how far the cloth's middle is from where it should be, m.
    fn outcome(self, fps: f64) -> (Seen, f64) {
        let mut scene = self.scene(fps);
        scene.stage.run(CALM);
        let before = middle(scene.stage.positions(scene.cloth));
        scene.stage.take_seen();
        self.happen(&mut scene);
        scene.stage.run(SECONDS);
        let after = middle(scene.stage.positions(scene.cloth));
        let expected = match self {
            Self::Paused(distance) | Self::ParentPaused(distance) | Self::Disabled(distance) => {
                before + DVec3::X * f64::from(distance)
            }
            Self::TurnedPaused(degrees) => turn(degrees).as_dquat() * before,
            Self::ShiftCape(distance) | Self::ShiftBox(distance) | Self::ShiftGround(distance) => {
                before + shift(distance).as_dvec3()
            }
            Self::Reparent => DVec3::X * 5.0 + turn(90.0).as_dquat() * before,
            Self::ReparentInPlace => before,
            // Where it is then is its own affair.
            Self::OtherEdge | Self::PinAgain | Self::Target => after,
        };
        (scene.stage.take_seen(), after.distance(expected))
    }

    fn rows(self, rates: &[f64]) -> Vec<Row> {
        let scene = self.name();
        let all: Vec<_> = rates.iter().map(|&fps| (fps, self.outcome(fps))).collect();
        vec![
            worst(&scene, "stretch/%", all.iter().map(|(fps, (seen, _))| (*fps, 100.0 * seen.stretch)), STRETCH),
            worst(&scene, "fastest/(m/s)", all.iter().map(|(fps, (seen, _))| (*fps, seen.fastest)), SPEED),
            worst(&scene, "off its place/mm", all.iter().map(|(fps, (_, off))| (*fps, 1e3 * off)), 50.0),
        ]
    }
}

fn turn(degrees: f32) -> Quat {
    Quat::from_rotation_y(degrees.to_radians())
}

/// Not along an axis.
fn shift(distance: f32) -> Vec3 {
    Vec3::new(0.8, 0.0, 0.6) * distance
}

fn middle(positions: &[DVec3]) -> DVec3 {
    positions.iter().sum::<DVec3>() / positions.len() as f64
}

/// All events at several frame rates.
pub fn rows(quick: bool) -> Vec<Row> {
    let (events, rates) = if quick { (&QUICK[..], &[60.0][..]) } else { (&EVENTS[..], &[30.0, 60.0, 144.0][..]) };
    events.iter().flat_map(|event| event.rows(rates)).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_sheet_on_a_box_lies_there_before_anything_happens() {
        let mut scene = Event::ShiftBox(1.0).scene(60.0);
        scene.stage.run(CALM);
        let positions = scene.stage.positions(scene.cloth);
        let highest = positions.iter().map(|p| p.y).fold(0.0, f64::max);
        assert!((highest - f64::from(TOP)).abs() < 0.02, "{highest}");
    }

    #[test]
    fn shifts_are_as_long_as_they_say() {
        assert!((shift(3.0).length() - 3.0).abs() < 1e-6);
    }
}
