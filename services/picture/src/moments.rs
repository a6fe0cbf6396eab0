//! Which moments of a run are shown: a choice of times by what happens and by what is in view.

/// Simulated time between the first moment and the first blow, at most \[s\].
const LEAD: f64 = 0.12;
/// Exponent of the moments after the blow where bodies break: most happens early.
const CROWDING: f64 = 2.1;
/// Something is in view where bodies that can move take at least this share of what they take at
/// most \[1\]: a chip that is left on a bare floor is no picture of a run.
const LEAST_IN_VIEW: f64 = 0.02;

/// What is in view at a time.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Glimpse {
    /// \[s\].
    pub(super) time: f64,
    /// How much of the picture bodies take that can move \[1\].
    pub(super) in_view: f64,
    /// Whether one of them moves.
    pub(super) moves: bool,
}

/// What moments are chosen by.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct RunOutline {
    /// The part of the run worth showing \[s\].
    pub(super) window: (f64, f64),
    /// When the first thing breaks, dents, tears or comes apart, or is struck \[s\].
    pub(super) blow: Option<f64>,
    /// Step of the world \[s\].
    pub(super) step: f64,
    /// Whether things happen all the time, as with sheets, and not mostly soon after the blow.
    pub(super) is_even: bool,
    /// Whether the scene says when the pictures end.
    pub(super) has_end: bool,
    /// What is in view when, by rising time; nothing where that is not known.
    pub(super) glimpses: Vec<Glimpse>,
}

impl RunOutline {
    /// So many moments, in order: one before the first blow, the last one before it, and the others
    /// after it until the end of what is seen. Where things happen all the time, they are at equal
    /// distances, but for the one between start and end that is nearest to the blow, which is just
    /// after it. None is a moment at which nothing that can move is in view, if there is another.
    pub(super) fn choose_moments(&self, count: usize) -> Vec<f64> {
        let seen: Vec<f64> = self.list_seen().map(|glimpse| glimpse.time).collect();
        let mut moments = self.spread_moments(count);
        for time in &mut moments {
            *time = self.find_nearest_seen(*time, &seen);
        }
        moments
    }

    /// The part of the run that is shown: without its ends at which nothing is in view, and, unless
    /// the scene says when it ends, without what is the same as at its end \[s\].
    pub(super) fn find_shown_span(&self) -> (f64, f64) {
        let (start, end) = self.window;
        let seen: Vec<&Glimpse> = self.list_seen().collect();
        let (Some(first), Some(last)) = (seen.first(), seen.last()) else { return self.window };
        let rests = seen.iter().rposition(|glimpse| glimpse.moves).map(|moving| moving + 1);
        let rest = rests.and_then(|at| seen.get(at)).filter(|_| !self.has_end);
        // At the ends nothing is cut off if they are in view themselves.
        let from = if self.is_first(first) { start } else { first.time };
        let until = if self.is_last(last) { end } else { last.time };
        let blow = self.blow.filter(|blow| (from..until).contains(blow));
        let until = rest.map_or(until, |rest| until.min(rest.time));
        // The blow is shown, whatever moves then.
        (from, blow.map_or(until, |blow| until.max(blow + 2.0 * self.step).min(end)).max(from))
    }

    fn is_first(&self, glimpse: &Glimpse) -> bool {
        self.glimpses.first() == Some(glimpse)
    }

    fn is_last(&self, glimpse: &Glimpse) -> bool {
        self.glimpses.last() == Some(glimpse)
    }

    /// The glimpses in which something is in view; all, where nothing ever is.
    fn list_seen(&self) -> impl Iterator<Item = &Glimpse> {
        let most = self.glimpses.iter().map(|glimpse| glimpse.in_view).fold(0.0, f64::max);
        self.glimpses.iter().filter(move |glimpse| glimpse.in_view >= LEAST_IN_VIEW * most)
    }

    /// The moments as they would be if something were in view all the time.
    fn spread_moments(&self, count: usize) -> Vec<f64> {
        let (start, end) = self.find_shown_span();
        let share = |k: usize| k as f64 / (count.max(2) - 1) as f64;
        let even = || (0..count).map(|k| start + (end - start) * share(k)).collect::<Vec<f64>>();
        let Some(blow) = self.blow.filter(|blow| (start..end).contains(blow)) else {
            return even();
        };
        // The first picture after the blow shows at least one step of it.
        let after = (blow + 1.01 * self.step).min(end);
        if self.is_even {
            let mut moments = even();
            let apart = |time: &f64| (time - after).abs();
            // The start and the end stay.
            let inner = moments.iter_mut().skip(1).take(count.saturating_sub(2));
            let nearest = inner.min_by(|a, b| apart(a).total_cmp(&apart(b)));
            if let Some(time) = nearest {
                *time = after;
            }
            return moments;
        }
        let before = [start.max(blow - LEAD), (blow - 0.51 * self.step).max(start)];
        let lead = before.len().min(count.saturating_sub(1));
        let later = count - lead;
        let crowded = (1..=later).map(|k| {
            let share = libm::pow(k as f64 / later as f64, CROWDING);
            if later == 1 { after } else { (blow + (end - blow) * share).max(after) }
        });
        before[before.len() - lead..].iter().copied().chain(crowded).collect()
    }

    /// A time itself if something is in view then, or else the nearest time at which something is.
    fn find_nearest_seen(&self, time: f64, seen: &[f64]) -> f64 {
        let next = self.glimpses.partition_point(|glimpse| glimpse.time < time);
        let around = [next.checked_sub(1), Some(next)];
        let mut around = around.into_iter().flatten().filter_map(|at| self.glimpses.get(at));
        // Between two glimpses there is what both have.
        if around.all(|glimpse| seen.contains(&glimpse.time)) {
            return time;
        }
        let apart = |other: &&f64| (*other - time).abs();
        let nearest = seen.iter().min_by(|a, b| apart(a).total_cmp(&apart(b)));
        nearest.copied().unwrap_or(time)
    }
}

#[cfg(test)]
mod tests {
    use super::{Glimpse, RunOutline};

    /// A run of two seconds that is struck at half a second; `state` says what is in view, and
    /// whether it moves.
    fn outline(is_even: bool, state: impl Fn(f64) -> (f64, bool)) -> RunOutline {
        let times = (0..=100).map(|k| 0.02 * f64::from(k));
        let glimpse = |time| {
            let (in_view, moves) = state(time);
            Glimpse { time, in_view, moves }
        };
        let glimpses = times.map(glimpse).collect();
        let (window, blow, step) = ((0.0, 2.0), Some(0.5), 0.004);
        RunOutline { window, blow, step, is_even, has_end: false, glimpses }
    }

    fn are_in_order(moments: &[f64], count: usize) {
        assert_eq!(moments.len(), count, "{moments:?}");
        assert!(moments.is_sorted(), "{moments:?}");
    }

    #[test]
    fn the_first_blow_is_among_the_moments_however_many_there_are() {
        for (is_even, count) in [(false, 4), (false, 8), (true, 5), (true, 8), (false, 30)] {
            let run = outline(is_even, |_| (0.3, true));
            let moments = run.choose_moments(count);
            are_in_order(&moments, count);
            let before = moments.iter().any(|&time| (0.496..0.5).contains(&time));
            let after =
                moments.iter().any(|&time| time > 0.503 && time < 0.56 + 1.5 / count as f64);
            assert!(after && (before || is_even), "{moments:?}");
            let just_after =
                moments.iter().any(|time| (time - 0.5 - 1.01 * run.step).abs() < 1e-12);
            assert!(just_after || !is_even, "{moments:?}");
            assert_eq!((moments[0] < 0.4, *moments.last().expect("some")), (true, 2.0));
            assert_eq!(moments, run.choose_moments(count), "again");
        }
        // A blow near the start does not take its place.
        let early = RunOutline { blow: Some(0.02), ..outline(true, |_| (0.3, true)) };
        assert_eq!(early.choose_moments(8)[..2], [0.0, 0.02 + 1.01 * early.step]);
        let run = outline(false, |_| (0.3, true));
        assert!(run.choose_moments(0).is_empty());
        for (count, first) in [(1, 0), (2, 1), (3, 2)] {
            let moments = run.choose_moments(count);
            assert!((moments[first] - 0.50404).abs() < 1e-9, "just after it: {moments:?}");
        }
    }

    #[test]
    fn no_moment_is_empty_while_another_is_not() {
        // Pieces fly out of the picture; the body comes into it; both; and a gap between.
        type InView = fn(f64) -> bool;
        let all: [InView; 4] =
            [|t| t < 0.71, |t| t > 0.3, |t| t > 0.1 && t < 0.9, |t| !(0.6..1.3).contains(&t)];
        for (in_view, is_even) in all.into_iter().flat_map(|it| [(it, false), (it, true)]) {
            let run =
                outline(is_even, |time| if in_view(time) { (0.2, true) } else { (1e-4, true) });
            let moments = run.choose_moments(8);
            are_in_order(&moments, 8);
            assert!(moments.iter().all(|&time| in_view(time)), "{moments:?}");
            assert!(
                moments.iter().any(|&time| (0.48..0.5).contains(&time)) || is_even,
                "{moments:?}"
            );
            let (from, until) = run.find_shown_span();
            assert!(in_view(from) && in_view(until), "{from} to {until}");
        }
        let nothing = outline(false, |_| (0.0, false));
        assert_eq!(nothing.choose_moments(8).last(), Some(&2.0), "where all are empty");
    }

    #[test]
    fn the_end_is_that_of_what_moves_unless_the_scene_says_when() {
        let mut run = outline(false, |time| (0.3, time < 1.1));
        let moments = run.choose_moments(8);
        are_in_order(&moments, 8);
        assert!((moments[7] - 1.1).abs() < 0.03, "{moments:?}");
        run.has_end = true;
        assert_eq!(run.choose_moments(8)[7], 2.0);
        // Nothing moves after the blow, which is shown all the same.
        let still = outline(false, |time| (0.3, time < 0.4)).choose_moments(8);
        assert!(still[7] > 0.5, "{still:?}");
    }

    #[test]
    fn without_a_blow_or_knowledge_of_what_is_in_view_moments_are_evenly_spread() {
        let run =
            RunOutline { blow: None, glimpses: Vec::new(), ..outline(false, |_| (0.3, true)) };
        let moments = run.choose_moments(8);
        let due = |k: usize| 2.0 * k as f64 / 7.0;
        assert!((0..8).all(|k| (moments[k] - due(k)).abs() < 1e-12), "{moments:?}");
        assert_eq!(run.find_shown_span(), (0.0, 2.0));
    }
}
