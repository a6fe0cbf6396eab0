//! A close view of one body: from where it fits into the picture with its pieces at their largest
//! extent, from before it is struck until a second later. What flies off is not followed.

use super::direct;
use super::stage::Focus;
use super::track::{Actor, Track};
use cullet_geometry::{Pose, Vec3};
use cullet_record::RecordError;
use std::collections::BTreeSet;
use std::path::Path;

/// How long after the first blow its pieces are followed \[s\].
const FOLLOWED: f64 = 1.0;
/// Moments at which they are looked at.
const LOOKS: u32 = 24;
/// Share of the size of what is near, as a sum over boxes, that the picture has to hold: chips that
/// fly about would make the rest small.
const HELD: f64 = 0.9;
/// What is near: as far from the middle of the struck body as this many of its diagonals. What is
/// shot away would push the camera far off.
const NEAR: f64 = 1.0;

/// The name, if the run has such a body.
pub(super) fn checked<'a>(
    track: &Track,
    name: &'a str,
    path: &Path,
) -> Result<&'a str, RecordError> {
    let rigid = track.actors.iter().map(|actor| &actor.object[..]);
    let names: BTreeSet<&str> = rigid.chain(track.sheets.iter().map(|it| &it.name[..])).collect();
    if names.contains(name) {
        return Ok(name);
    }
    let known = names.into_iter().collect::<Vec<_>>().join(", ");
    Err(RecordError::NoBody { path: path.to_owned(), name: name.to_owned(), known })
}

/// The same view from where a body, or the first that is struck, fills the picture.
pub(super) fn focus(
    track: &Track,
    focus: &Focus,
    body: Option<&str>,
    size: (usize, usize),
) -> Focus {
    let Some(name) = body.or_else(|| struck(track)) else { return *focus };
    let since = first_blow(track, name).unwrap_or(0.0);
    let end = (since + FOLLOWED).min(track.end);
    let before = (since - 1.5 * track.step).max(0.0);
    let share = |k: u32| f64::from(k) / f64::from(LOOKS);
    let times: Vec<f64> =
        (0..=LOOKS).map(|k| before + (end - before).max(0.0) * share(k)).collect();
    let place = CloseRegion::of(track, name, before);
    let mut points: Vec<Vec3> =
        times.iter().flat_map(|&time| held(track, name, (time, &place))).collect();
    let sheet = direct::sheet_points(track, &times, Some(name));
    points.extend(sheet.into_iter().filter(|point| place.is_near(point)));
    direct::on(&points, (track, focus), size)
}

/// Where a body is when it is struck.
struct CloseRegion {
    middle: Vec3,
    /// How far from there its pieces are looked at \[m\].
    reach: f64,
}

impl CloseRegion {
    /// By the largest of its pieces at that time, or by the points of a sheet; everywhere, if
    /// nothing of it is there.
    fn of(track: &Track, name: &str, time: f64) -> Self {
        let own = track.present(time).filter(|(_, it, _)| it.object == name && !it.is_grain());
        let diagonal = |actor: &Actor| (actor.mesh.bounds[1] - actor.mesh.bounds[0]).norm();
        let largest = own.max_by(|a, b| diagonal(a.1).total_cmp(&diagonal(b.1)));
        let points = largest.map_or_else(
            || direct::sheet_points(track, &[time], Some(name)),
            |(_, actor, pose)| actor.corners(pose).to_vec(),
        );
        match cullet_geometry::mesh::bounds(&points) {
            Some((low, high)) => {
                Self { middle: 0.5 * (low + high), reach: NEAR * (high - low).norm() }
            }
            None => Self { middle: Vec3::zeros(), reach: f64::INFINITY },
        }
    }

    fn is_near(&self, point: &Vec3) -> bool {
        (point - self.middle).norm() <= self.reach
    }
}

/// The object that is struck first among those that break or dent; among all that move, where
/// none does; a sheet, where nothing else moves.
fn struck(track: &Track) -> Option<&str> {
    let of = |id: u64| track.actors.iter().find(|actor| actor.id == id);
    let both = track.strikes.iter().flat_map(|&(_, body, striker)| [body, striker]);
    let hit: Vec<&Actor> = both.filter_map(of).filter(|actor| !actor.fixed).collect();
    let broken: BTreeSet<&str> = track
        .actors
        .iter()
        .filter(|actor| actor.fragment || actor.deformed)
        .map(|actor| &actor.object[..])
        .collect();
    let first = hit.iter().find(|actor| broken.contains(&actor.object[..]));
    let first = first.or(hit.first()).map(|actor| &actor.object[..]);
    let broke = || track.breaks.first().and_then(|&(_, id)| of(id)).map(|it| &it.object[..]);
    first.or_else(broke).or_else(|| track.sheets.first().map(|sheet| &sheet.name[..]))
}

/// When an object is first struck or breaks \[s\].
fn first_blow(track: &Track, name: &str) -> Option<f64> {
    let own = |id: u64| track.actors.iter().any(|it| it.id == id && it.object == name);
    let strikes = track.strikes.iter().filter(|(_, a, b)| own(*a) || own(*b)).map(|it| it.0);
    let breaks = track.breaks.iter().filter(|(_, id)| own(*id)).map(|it| it.0);
    strikes.chain(breaks).min_by(f64::total_cmp)
}

/// Corners of the boxes of an object's pieces at a time, without the far ones and, of those near,
/// without the small and farther ones.
fn held(track: &Track, name: &str, (time, place): (f64, &CloseRegion)) -> Vec<Vec3> {
    let size = |actor: &Actor| {
        let sides = actor.mesh.bounds[1] - actor.mesh.bounds[0];
        (sides.x * sides.y * sides.z).max(f64::MIN_POSITIVE)
    };
    let away = |pose: &Pose| (pose.translation.vector - place.middle).norm();
    let mut near: Vec<(&Actor, &Pose)> = track
        .present(time)
        .filter(|(_, actor, _)| actor.object == name && !actor.is_grain())
        .map(|(_, actor, pose)| (actor, pose))
        .filter(|(_, pose)| place.is_near(&pose.translation.vector))
        .collect();
    near.sort_by(|a, b| away(a.1).total_cmp(&away(b.1)).then(a.0.id.cmp(&b.0.id)));
    let wanted = HELD * near.iter().map(|(actor, _)| size(actor)).sum::<f64>();
    let mut sum = 0.0;
    let held = near.into_iter().take_while(|(actor, _)| {
        let lacks = sum < wanted;
        sum += size(actor);
        lacks
    });
    held.flat_map(|(actor, pose)| actor.corners(pose)).collect()
}
