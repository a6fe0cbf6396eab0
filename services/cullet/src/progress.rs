//! How a run looks while it goes: a bar on a terminal, plain lines elsewhere.

use crate::logs;
use crate::shown::lines;
use cullet_coordinator::run::{News, Position};
use indicatif::{ProgressBar, ProgressStyle};
use std::io::{IsTerminal, stderr};
use std::time::{Duration, Instant};

/// Where there is no terminal, say where the run is this often.
const PLAIN_PERIOD: Duration = Duration::from_secs(5);
/// Parts of the bar; finer than any terminal is wide.
const PARTS: u64 = 1000;

/// Shows news of a run on standard error.
pub(crate) struct Progress {
    bar: Option<ProgressBar>,
    quiet: bool,
    started: Instant,
    told: Instant,
}

impl Progress {
    pub(crate) fn new(quiet: bool) -> Self {
        let bar = (!quiet && logs::plain() && stderr().is_terminal()).then(|| {
            let bar = ProgressBar::new(PARTS);
            let style = ProgressStyle::with_template("{bar:24} {msg}  {elapsed} + {eta}");
            bar.set_style(style.unwrap_or_else(|_| ProgressStyle::default_bar()));
            bar.enable_steady_tick(Duration::from_millis(250));
            bar
        });
        let now = Instant::now();
        Self { bar, quiet, started: now, told: now }
    }

    pub(crate) fn show(&mut self, news: &News) {
        if self.quiet {
            return;
        }
        match (news, &self.bar) {
            (News::Line(line), Some(bar)) => bar.println(lines(line)),
            (News::Line(line), None) => logs::say(lines(line)),
            (News::At(position), Some(bar)) => {
                bar.set_position((share(position) * PARTS as f64) as u64);
                bar.set_message(text(position));
            }
            (News::At(position), None) => self.plain(position),
        }
    }

    fn plain(&mut self, position: &Position) {
        if self.told.elapsed() < PLAIN_PERIOD {
            return;
        }
        self.told = Instant::now();
        let (share, spent) = (share(position), self.started.elapsed().as_secs_f64());
        // Earlier, the first hit tells of nothing but itself.
        let known = share > 0.1;
        let left = known.then(|| format!(", {:.0} s left", spent * (1.0 - share) / share));
        logs::say(text(position) + &left.unwrap_or_default());
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
    let Position { time, end, bodies, fractures, jobs, permille } = p;
    let at = format!("{time:.3} of {end:.3} s, {bodies} bodies, {fractures} fractures");
    let solving = Some(permille / 10).filter(|_| *permille > 0);
    let solving = solving.map(|percent| format!(" (at work: {percent} %)")).unwrap_or_default();
    format!("{at}, {jobs} jobs to do{solving}")
}

#[cfg(test)]
mod tests {
    use super::text;
    use cullet_coordinator::run::Position;

    #[test]
    fn a_line_says_how_far_the_solves_are() {
        let (time, end, bodies, fractures) = (0.5, 2.0, 3, 1);
        let at = Position { time, end, bodies, fractures, jobs: 2, permille: 0 };
        let line = "0.500 of 2.000 s, 3 bodies, 1 fractures, 2 jobs to do";
        assert_eq!(text(&at), line);
        assert_eq!(text(&Position { permille: 474, ..at }), format!("{line} (at work: 47 %)"));
    }
}
