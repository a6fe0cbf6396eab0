//! Where to look and when: found from what breaks.

use super::camera::Camera;
use super::glimpse::take_glimpse;
use super::moments::RunOutline;
use super::sheets::SheetActor;
use super::stage::Focus;
use super::track::{Actor, Track, vector};
use cullet_geometry::Vec3;
use std::collections::{BTreeMap, BTreeSet};

/// Simulated time shown before the first break \[s\].
const LEAD: f64 = 0.25;
/// Simulated time shown after the last break \[s\].
const TAIL: f64 = 1.6;
/// Moments of a contact sheet.
pub(super) const MOMENTS: usize = 8;
/// Parts of the time worth showing, at whose ends it is looked what is in view.
const GLIMPSES: u32 = 120;
/// Bodies larger than this many times the action are a stage, not actors.
const STAGE: f64 = 4.0;

/// When the first thing breaks, dents or comes apart, or what comes closest to it \[s\].
pub(super) fn climax(track: &Track) -> Option<f64> {
    let first = list_breaks(track).reduce(f64::min);
    first.or_else(|| track.strikes.first().map(|s| s.0))
}

/// When bodies and joints break \[s\].
fn list_breaks(track: &Track) -> impl Iterator<Item = f64> {
    track.breaks.iter().map(|broken| broken.0).chain(track.parted.iter().copied())
}

/// Share of the debris, along each axis, that may be out of the picture.
const OUTLIERS: f64 = 0.1;
/// The same of a close view.
const CLOSE_OUTLIERS: f64 = 0.02;
/// How far from the middle of the action, in its sizes, a bystander may be and still be shown.
const NEIGHBOURS: f64 = 0.9;

/// The part of the run worth showing \[s\].
pub(super) fn window(track: &Track) -> (f64, f64) {
    let (mut start, mut end) = (0.0, track.end);
    // What moves as it deforms is worth it all the time.
    if let Some(first) = climax(track).filter(|_| track.sheets.is_empty()) {
        let last = list_breaks(track).fold(first, f64::max);
        (start, end) = ((first - LEAD).max(0.0), (last + TAIL).min(track.end));
    }
    let [first, last] = track.wanted;
    let end = last.unwrap_or(end).min(track.end);
    (first.unwrap_or(start).clamp(0.0, end), end)
}

/// What moments of a run are chosen by, as far as it does not hang on where it is seen from.
fn outline_unseen_run(track: &Track) -> RunOutline {
    let is_even = !track.sheets.is_empty() && list_breaks(track).next().is_none();
    let torn = track.sheets.iter().filter_map(SheetActor::find_first_tear).reduce(f64::min);
    let (window, step) = (window(track), track.step);
    let blow = if is_even { torn } else { climax(track).into_iter().chain(torn).reduce(f64::min) };
    let has_end = track.wanted[1].is_some();
    RunOutline { window, blow, step, is_even, has_end, glimpses: Vec::new() }
}

/// What moments of a run are chosen by, seen by a camera in a picture of a size.
pub(super) fn outline_run(track: &Track, view: (&Camera, (usize, usize))) -> RunOutline {
    let blind = outline_unseen_run(track);
    let (start, end) = blind.window;
    let time = |k: u32| start + (end - start) * f64::from(k) / f64::from(GLIMPSES);
    let glimpses = (0..=GLIMPSES).map(|k| take_glimpse(track, view, time(k))).collect();
    RunOutline { glimpses, ..blind }
}

/// The moments that a camera has to take in.
pub(super) fn moments(track: &Track) -> Vec<f64> {
    outline_unseen_run(track).choose_moments(MOMENTS)
}

/// The objects that break or dent, or all that move where none does.
fn heroes(track: &Track) -> BTreeSet<&str> {
    let broken: BTreeSet<&str> = track
        .actors
        .iter()
        .filter(|a| a.fragment || a.deformed)
        .map(|a| a.object.as_str())
        .collect();
    if !broken.is_empty() {
        return broken;
    }
    track.actors.iter().filter(|a| !a.fixed).map(|a| a.object.as_str()).collect()
}

/// One camera for all pictures of a run of `size` pixels.
pub(super) fn focus(track: &Track, meta: &BTreeMap<String, String>, size: (usize, usize)) -> Focus {
    let points = action(track);
    let (low, high) = extent(&points);
    let target = (low + high) / 2.0;
    let reach = ((high - low).norm() / 2.0).max(1e-3);
    let floor = own_floor(track, &points);
    let view = (vector(meta.get("view.eye")), vector(meta.get("view.target")));
    let (Some(eye), Some(wanted)) = view else {
        let camera = Camera::fit(&points, direction(track), track.up, size);
        return Focus { camera, target, reach, floor };
    };
    let fov = meta.get("view.fov").and_then(|s| s.parse().ok()).unwrap_or(40.0);
    let camera = Camera::look((eye, wanted), track.up, fov, size);
    // What flies out of the picture must not coarsen the shadows in it.
    let shown = camera.reach((wanted - eye).norm(), size).max(1e-3);
    if shown < reach {
        return Focus { camera, target: wanted, reach: shown, floor };
    }
    Focus { camera, target, reach, floor }
}

/// The same view from where what breaks, or the body of that name, fills the picture at a moment.
pub(super) fn close(
    track: &Track,
    focus: &Focus,
    body: Option<&str>,
    (time, size): (f64, (usize, usize)),
) -> Focus {
    let heroes = body.map_or_else(|| heroes(track), |name| BTreeSet::from([name]));
    let present = track.present(time).filter(|(_, actor, _)| {
        let stands = actor.fixed && body.is_none();
        heroes.contains(actor.object.as_str()) && !stands && !actor.is_grain()
    });
    let corners: Vec<Vec3> = present.flat_map(|(_, a, pose)| a.corners(pose)).collect();
    let mut points = gathered(&corners, CLOSE_OUTLIERS);
    points.extend(sheet_points(track, &[time], body));
    on(&points, (track, focus), size)
}

/// The same view from where these points fill the picture; without any, as it is.
pub(super) fn on(points: &[Vec3], (track, focus): (&Track, &Focus), size: (usize, usize)) -> Focus {
    if points.is_empty() {
        return *focus;
    }
    let (low, high) = extent(points);
    Focus {
        camera: Camera::fit(points, focus.camera.forward, track.up, size),
        target: (low + high) / 2.0,
        reach: ((high - low).norm() / 2.0).max(1e-3),
        ..*focus
    }
}

/// Corners of the boxes of what matters, at the moments shown.
fn action(track: &Track) -> Vec<Vec3> {
    let heroes = heroes(track);
    let (mut whole, mut debris) = (Vec::new(), Vec::new());
    let moments = moments(track);
    for &time in &moments {
        for (_, actor, pose) in track.present(time) {
            if heroes.contains(actor.object.as_str()) && !actor.fixed && !actor.is_grain() {
                let points = if actor.fragment { &mut debris } else { &mut whole };
                points.extend(actor.corners(pose));
            }
        }
    }
    whole.extend(gathered(&debris, OUTLIERS));
    whole.extend(sheet_points(track, &moments, None));
    let (low, high) = extent(&whole);
    let (middle, size) = ((low + high) / 2.0, (high - low).norm());
    for (_, actor, pose) in track.present(moments[1]) {
        let near = (pose.translation.vector - middle).norm() < NEIGHBOURS * size;
        if near && !actor.fixed && !actor.is_grain() && size_of(actor) < STAGE * size {
            whole.extend(actor.corners(pose));
        }
    }
    if whole.is_empty() {
        whole.extend(track.present(0.0).flat_map(|(_, actor, pose)| actor.corners(pose)));
    }
    whole
}

/// Places of the points of sheets, or of the one of that name, at these times, without those of
/// pieces that flew far.
pub(super) fn sheet_points(track: &Track, times: &[f64], name: Option<&str>) -> Vec<Vec3> {
    let there = times.iter().flat_map(|&time| track.sheets_at(time));
    let wanted = there.filter(|(_, sheet, _)| name.is_none_or(|name| sheet.name == name));
    let all: Vec<Vec3> = wanted.flat_map(|(.., at)| at.places().to_vec()).collect();
    gathered(&all, CLOSE_OUTLIERS)
}

/// Debris without what flew far: it must not shrink the rest.
fn gathered(debris: &[Vec3], outliers: f64) -> Vec<Vec3> {
    let mut kept = debris.to_vec();
    for axis in 0..3 {
        let mut along: Vec<f64> = debris.iter().map(|p| p[axis]).collect();
        along.retain(|c| c.is_finite());
        along.sort_by(f64::total_cmp);
        let skip = (along.len() as f64 * outliers / 2.0) as usize;
        if let (Some(&low), Some(&high)) = (along.get(skip), along.iter().rev().nth(skip)) {
            kept.retain(|p| (low..=high).contains(&p[axis]));
        }
    }
    kept
}

fn size_of(actor: &Actor) -> f64 {
    (actor.mesh.bounds[1] - actor.mesh.bounds[0]).norm()
}

fn extent(points: &[Vec3]) -> (Vec3, Vec3) {
    let none = (Vec3::repeat(-0.5), Vec3::repeat(0.5));
    let mut both = points.iter().filter(|p| p.iter().all(|c| c.is_finite()));
    let Some(&first) = both.next() else {
        return none;
    };
    both.fold((first, first), |(low, high), p| (low.inf(p), high.sup(p)))
}

fn by_id(track: &Track, id: u64) -> Option<&Actor> {
    track.actors.iter().find(|a| a.id == id)
}

/// What hit the first body to break.
fn striker(track: &Track) -> Option<&Actor> {
    let &(time, broken) = track.breaks.first()?;
    let mut before = track.strikes.iter().filter(|s| s.0 <= time);
    let (_, a, b) = before.rfind(|s| s.1 == broken || s.2 == broken)?;
    by_id(track, if *a == broken { *b } else { *a })
}

/// Where to look: across the way of the striker and a little along it, from above.
fn direction(track: &Track) -> Vec3 {
    let up = track.up;
    let time = climax(track).unwrap_or(0.0) - 1.5 * track.step;
    let velocity =
        striker(track).filter(|s| !s.fixed).map_or_else(Vec3::zeros, |s| s.velocity(time));
    let level = velocity - up * velocity.dot(&up);
    let way = level.try_normalize(0.3).unwrap_or_else(|| {
        let side = if up.x.abs() > 0.5 { Vec3::y() } else { Vec3::x() };
        (side - up * side.dot(&up)).try_normalize(1e-9).unwrap_or_else(Vec3::y)
    });
    let across = up.cross(&way);
    way * 0.62 + across * 0.78 - up * 0.42
}

/// A scene without anything fixed gets a floor below all that is looked at.
fn own_floor(track: &Track, points: &[Vec3]) -> Option<f64> {
    if track.actors.iter().any(|a| a.fixed) {
        return None;
    }
    let heights = points.iter().map(|p| p.dot(&track.up)).filter(|h| h.is_finite());
    let lowest = heights.fold(f64::INFINITY, f64::min);
    lowest.is_finite().then_some(lowest)
}
