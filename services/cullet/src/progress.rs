//! How a run looks while it goes: a bar on a terminal, plain lines elsewhere.

use crate::logs;
use crate::shown::lines;
use cullet_run::{News, Position};
use indicatif::{ProgressBar, ProgressStyle};
use std::io::{IsTerminal, stderr};
use std::time::{Duration, Instant};

/// Where there is no terminal, say where the run is this often.
const PLAIN_PERIOD: Duration = Duration::from_secs(5);
/// Parts of the bar; finer than any terminal is wide.
const PARTS: u64 = 1000;

/// Shows the progress of a run on standard error.
pub(crate) struct ProgressDisplay {
    bar: Option<ProgressBar>,
    quiet: bool,
    started: Instant,
    told: Instant,
    pace: Pace,
}

/// How fast a run gets on: smoothed over a short time and over a long one.
#[derive(Debug, Default)]
struct Pace {
    wall: f64,
    share: f64,
    /// Share of the run in a second of wall time [1/s].
    short: f64,
    long: f64,
    /// When simulated time went on last: while a solve is waited for it stands still.
    moved: f64,
    /// Since when the two agree.
    steady: Option<f64>,
}

/// Before so much of a run is done, or so many seconds have passed, nothing is known of the rest:
/// the first hit tells of nothing but itself.
const LEAST_SHARE: f64 = 0.1;
const LEAST_WALL: f64 = 3.0;
/// What the paces are smoothed over: seconds, and this part of the time so far.
const SHORT: f64 = 2.0;
const LONG: f64 = 0.5;
/// The two paces may differ by this factor, and must not for so many seconds.
const ALIKE: f64 = 1.5;
const STEADY: f64 = 2.0;
/// A run that has not moved for so many seconds waits for a solve.
const STILL: f64 = 1.0;

impl Pace {
    /// So much of the run is done after so many seconds; about how many more it takes, if that can
    /// be told.
    fn left(&mut self, wall: f64, share: f64) -> Option<f64> {
        let (passed, done) = (wall - self.wall, share - self.share);
        if passed > 0.0 {
            let smooth = |before: f64, span: f64| {
                before + passed / (passed + span.min(LONG * wall)) * (done / passed - before)
            };
            (self.short, self.long) = (smooth(self.short, SHORT), smooth(self.long, wall));
            (self.wall, self.share) = (wall, share);
        }
        if done > 0.0 {
            self.moved = wall;
        }
        let (least, most) = (self.short.min(self.long), self.short.max(self.long));
        let alike = least > 0.0 && most <= ALIKE * least && wall - self.moved < STILL;
        self.steady = self.steady.or(Some(wall)).filter(|_| alike);
        let known = self.steady.is_some_and(|since| wall - since >= STEADY);
        let known = known && share >= LEAST_SHARE && wall >= LEAST_WALL;
        known.then(|| (1.0 - share) / (least * most).sqrt())
    }
}

/// A time in words no finer than it is known.
fn about(seconds: f64) -> String {
    match seconds {
        s if s < 10.0 => format!("about {:.0} s left", s.ceil()),
        s if s < 100.0 => format!("about {:.0} s left", (s / 5.0).ceil() * 5.0),
        s if s < 6000.0 => format!("about {:.0} min left", (s / 60.0).ceil()),
        s => format!("about {:.0} h left", (s / 3600.0).ceil()),
    }
}

impl ProgressDisplay {
    pub(crate) fn new(quiet: bool) -> Self {
        let bar = (!quiet && logs::plain() && stderr().is_terminal()).then(|| {
            let bar = ProgressBar::new(PARTS);
            let style = ProgressStyle::with_template("{bar:24} {msg}  {elapsed}");
            bar.set_style(style.unwrap_or_else(|_| ProgressStyle::default_bar()));
            bar.enable_steady_tick(Duration::from_millis(250));
            bar
        });
        let now = Instant::now();
        Self { bar, quiet, started: now, told: now, pace: Pace::default() }
    }

    pub(crate) fn show(&mut self, news: &News) {
        if self.quiet {
            return;
        }
        let left = match news {
            News::At(position) => self.left(position),
            News::Line(_) | News::Results(_) => String::new(),
        };
        match (news, &self.bar) {
            (News::Line(line) | News::Results(line), Some(bar)) => bar.println(lines(line)),
            (News::Line(line) | News::Results(line), None) => logs::say(lines(line)),
            (News::At(position), Some(bar)) => {
                bar.set_position((share(position) * PARTS as f64) as u64);
                bar.set_message(text(position) + &left);
            }
            (News::At(position), None) => self.plain(position, &left),
        }
    }

    /// The time left as it is put after a line, if it can be told.
    fn left(&mut self, position: &Position) -> String {
        let left = self.pace.left(self.started.elapsed().as_secs_f64(), share(position));
        left.map(|seconds| format!(", {}", about(seconds))).unwrap_or_default()
    }

    fn plain(&mut self, position: &Position, left: &str) {
        if self.told.elapsed() < PLAIN_PERIOD {
            return;
        }
        self.told = Instant::now();
        logs::say(text(position) + left);
    }

    pub(crate) fn done(&self) {
        if let Some(bar) = &self.bar {
            bar.finish_and_clear();
        }
    }
}

fn share(position: &Position) -> f64 {
    if position.end > 0.0 { (position.time / position.end).clamp(0.0, 1.0) } else { 1.0 }
}

/// Where a run is, in a line: also how far those of its jobs are that workers solve.
pub(crate) fn text(p: &Position) -> String {
    let Position { time, end, bodies, fractures, jobs, permille, .. } = p;
    let at = format!("{time:.3} of {end:.3} s, {bodies} bodies, {fractures} fractures");
    let solving = Some(permille / 10).filter(|_| *permille > 0);
    let solving = solving.map(|percent| format!(" (at work: {percent} %)")).unwrap_or_default();
    format!("{at}, {jobs} jobs to do{solving}")
}

#[cfg(test)]
mod tests {
    use super::{Pace, text};
    use cullet_run::Position;

    #[test]
    fn a_line_says_how_far_the_solves_are() {
        let (time, end, bodies, fractures) = (0.5, 2.0, 3, 1);
        let at = Position { time, end, bodies, fractures, jobs: 2, ..Position::default() };
        let line = "0.500 of 2.000 s, 3 bodies, 1 fractures, 2 jobs to do";
        assert_eq!(text(&at), line);
        assert_eq!(text(&Position { permille: 474, ..at }), format!("{line} (at work: 47 %)"));
    }

    /// What was shown while a run went on: seconds since it began, and what was said to be left.
    fn shown(total: f64, share: impl Fn(f64) -> f64) -> Vec<(f64, f64)> {
        let mut pace = Pace::default();
        let looks = (1..(total / 0.05) as u32).map(|k| f64::from(k) * 0.05);
        looks.filter_map(|wall| Some((wall, pace.left(wall, share(wall))?))).collect()
    }

    /// A run of 23 s as a statue's is: a part of it goes by in no time, a solve takes 14 s, another
    /// 4 s, and the rest is steady.
    fn statue(wall: f64) -> f64 {
        let steady = |from: f64, to: f64, since: f64, span: f64| {
            from + (to - from) * ((wall - since) / span).clamp(0.0, 1.0)
        };
        match wall {
            w if w < 0.2 => steady(0.0, 0.04, 0.0, 0.2),
            w if w < 14.2 => 0.04,
            w if w < 15.0 => steady(0.04, 0.16, 14.2, 0.8),
            w if w < 19.0 => 0.16,
            _ => steady(0.16, 1.0, 19.0, 4.0),
        }
    }

    #[test]
    fn the_time_left_is_shown_only_when_it_means_something() {
        let even = shown(100.0, |wall| wall / 100.0);
        assert!(even.len() > 1_500, "an even run is told of: {} times", even.len());
        assert!(even.iter().all(|(wall, left)| (wall + left - 100.0).abs() < 5.0), "{even:?}");
        // What was shown of it came to 76 minutes.
        let uneven = shown(23.0, statue);
        let far = uneven.iter().filter(|(wall, left)| *left > 4.0 * (23.0 - wall).max(1.0));
        assert_eq!(far.collect::<Vec<_>>(), Vec::<&(f64, f64)>::new(), "{uneven:?}");
        // A run that stands still is never said to end soon.
        let still = shown(60.0, |wall| (wall / 10.0).min(0.5));
        let lies = still.iter().filter(|(wall, left)| *wall > 25.0 && *left < 5.0);
        assert_eq!(lies.count(), 0, "{still:?}");
    }
}
