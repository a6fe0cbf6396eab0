//! The one moment of a run that a still shows.

use super::direct;
use super::sheets::SheetActor;
use super::track::Track;

/// Which of [`direct::moments`] shows a break of rigid bodies: soon after it.
const SHOWN: usize = 2;

/// The moment that a still shows unless another time is given, and the sheet of a sweep \[s\]. Of
/// sheets that tear: when half of what is torn is; of sheets that come apart without, when half of
/// the pieces are there; of others, unless a rigid body breaks, when they are farthest from where
/// they were first.
pub(super) fn shown(track: &Track) -> f64 {
    let half = || half_way(track, |time| track.sheets.iter().map(|it| it.torn(time)).sum());
    let parts = || {
        let pieces = |time: f64| track.sheets.iter().map(|it| it.pieces(time).large()).sum::<u64>();
        half_way(track, |time| pieces(time) as f64)
    };
    let broke = || track.breaks.first().map(|_| direct::moments(track)[SHOWN]);
    let all = half().or_else(parts).or_else(broke).or_else(|| farthest(track));
    all.unwrap_or_else(|| direct::moments(track)[SHOWN])
}

/// When a number that grows with the windows of sheets has come half of its way, in what is worth
/// showing; nothing where it does not grow.
fn half_way(track: &Track, grown: impl Fn(f64) -> f64) -> Option<f64> {
    let (start, end) = direct::window(track);
    let mut times: Vec<f64> = track.sheets.iter().flat_map(SheetActor::windows).collect();
    times.retain(|time| (start..=end).contains(time));
    times.sort_by(f64::total_cmp);
    let (first, last) = (grown(start), grown(*times.last()?));
    let half = 0.5 * (first + last);
    times.into_iter().find(|&time| last > first && grown(time) >= half)
}

/// When sheets are farthest from where they were first; of several the one that goes farthest
/// counts.
fn farthest(track: &Track) -> Option<f64> {
    let (start, end) = direct::window(track);
    let all = track.sheets.iter().flat_map(SheetActor::ways);
    let inside = all.filter(|(time, way)| (start..=end).contains(time) && *way > 0.0);
    // Of equal ways the first.
    let farther = |best: (f64, f64), it: (f64, f64)| if it.1 > best.1 { it } else { best };
    inside.reduce(farther).map(|(time, _)| time)
}
