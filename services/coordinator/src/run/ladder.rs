//! The spacings at which one hit is solved, coarsest first: the finer one only where the coarser
//! two still differ by more than the scene allows, or where like hits did.

use cullet_proto::BrokenBody;
use cullet_world::fidelity::{Figures, Plan, branched, estimate};
use std::collections::{BTreeMap, VecDeque};

/// Spacings fall by this from one solve to the next: each costs sixteen times the one before.
const STEP: f64 = 2.0;

/// Spacings over the plan's below which a coarser solve is not worth its while.
const NEAR: f64 = 1.5;

/// Hits whose errors must be known before one like them is taken at its word.
const LIKE: usize = 3;

/// Errors of spacings, as far as hits of one run have told them; filled in the order in which jobs
/// settle, so that it is the same with any pool.
#[derive(Clone, Debug, Default)]
pub(super) struct Experience(BTreeMap<(Kind, u64), Vec<f64>>);

/// What makes hits alike: material, size of the body, speed and energy, in powers of two.
#[derive(Clone, Debug, Default, PartialEq, Eq, PartialOrd, Ord)]
pub(super) struct Kind(String, [i64; 3]);

impl Kind {
    /// `volume` \[m³\] of the body, `speed` \[m/s\] and `energy` \[J\] of the hardest of its hits.
    pub(super) fn new(material: &str, volume: f64, speed: f64, energy: f64) -> Self {
        let octave = |x: f64| libm::log2(x.max(f64::MIN_POSITIVE)).floor() as i64;
        Self(material.to_owned(), [volume, speed, energy].map(octave))
    }
}

impl Experience {
    fn learn(&mut self, kind: &Kind, spacing: f64, error: f64) {
        self.0.entry((kind.clone(), spacing.to_bits())).or_default().push(error);
    }

    /// The greatest error of a spacing, and of how many hits like this one.
    fn of(&self, kind: &Kind, spacing: f64) -> Option<(f64, usize)> {
        let known = self.0.get(&(kind.clone(), spacing.to_bits()))?;
        let greatest = known.iter().copied().fold(0.0, f64::max);
        (known.len() >= LIKE).then_some((greatest, known.len()))
    }
}

/// What follows a solve.
#[derive(Clone, Debug, PartialEq)]
pub(super) enum Next {
    /// It is used; with why no finer one follows, where one could.
    Use(Option<String>),
    /// A finer one, because.
    Finer(String),
}

/// What is left to solve of a hit, and what the last solve came to.
#[derive(Clone, Debug, Default)]
pub(super) struct Ladder {
    left: VecDeque<f64>,
    last: Option<Figures>,
    error: f64,
    kind: Kind,
}

impl Ladder {
    /// From the coarsest that the body bears to the plan's spacing; without an error that is good
    /// enough the plan's alone. A single coarser one would have nothing to be compared with.
    pub(super) fn new(plan: &Plan, error: Option<f64>, kind: Kind) -> Self {
        let coarser = std::iter::successors(Some(plan.coarsest), |h| Some(h / STEP));
        let coarser = coarser.take_while(|&h| error.is_some() && h > NEAR * plan.spacing);
        let mut left: VecDeque<f64> = coarser.collect();
        if left.len() < 2 {
            left.clear();
        }
        left.push_back(plan.spacing);
        Self { left, last: None, error: error.unwrap_or(0.0), kind }
    }

    /// The next spacing \[m\]; none where no plan was made or all are done.
    pub(super) fn climb(&mut self) -> Option<f64> {
        self.left.pop_front()
    }

    /// Whether finer solves could follow the one at hand.
    pub(super) fn goes_on(&self) -> bool {
        !self.left.is_empty()
    }

    /// Whether an outcome is good enough, by the solve before it or by hits like this one; the last
    /// is.
    pub(super) fn next(&mut self, outcome: Option<&BrokenBody>, seen: &mut Experience) -> Next {
        let (last, now) = (self.last.take(), outcome.map(figures));
        let mut reached = None;
        if let (Some(last), Some(now)) = (&last, &now) {
            // At first order the coarser one is that much further off.
            let error = estimate(last, now);
            seen.learn(&self.kind, last.spacing, error * last.spacing / now.spacing);
            seen.learn(&self.kind, now.spacing, error);
            let side = if error > self.error { "over" } else { "within" };
            let pieces = told(last.count, now.count);
            reached = Some(format!(
                "this is the plan's grid; its error is about {error:.2}, {side} {}{pieces}",
                self.error
            ));
        }
        if !self.goes_on() {
            return Next::Use(reached);
        }
        let Some(now) = now else {
            return Next::Finer("it did not come to an end on this grid".to_owned());
        };
        self.last = Some(now);
        let limit = self.error;
        if let Some(last) = last {
            let error = estimate(&last, &now);
            let pieces = told(last.count, now.count);
            return if error > limit {
                Next::Finer(format!("its error is about {error:.2}, over {limit}{pieces}"))
            } else {
                Next::Use(Some(format!("its error is about {error:.2}, within {limit}{pieces}")))
            };
        }
        match seen.of(&self.kind, now.spacing) {
            Some((error, count)) if error <= limit => Next::Use(Some(format!(
                "{count} hits like it had errors up to {error:.2} on this grid, within {limit}"
            ))),
            Some((error, count)) => Next::Finer(format!(
                "{count} hits like it had errors up to {error:.2} on this grid, over {limit}"
            )),
            None => Next::Finer("nothing to compare it with".to_owned()),
        }
    }
}

/// What is said of pieces whose number is the grid's, after what was said.
fn told(coarse: usize, fine: usize) -> String {
    branched(coarse, fine).map_or_else(String::new, |words| format!("; {words}"))
}

fn figures(broken: &BrokenBody) -> Figures {
    let volumes = broken.fragments.iter().map(|part| part.solid.mesh.signed_volume());
    let whole: f64 = volumes.clone().sum();
    let largest = volumes.fold(0.0, f64::max);
    let report = &broken.report;
    Figures {
        spacing: report.spacing,
        crack_area: report.crack_area,
        largest: largest / whole,
        count: broken.fragments.len(),
    }
}

#[cfg(test)]
mod tests {
    use super::{Experience, Kind, Ladder, Next};
    use cullet_proto::BrokenBody;
    use cullet_world::fidelity::{Bound, Plan, Regime};

    fn plan(coarsest: f64) -> Plan {
        Plan {
            regime: Regime::Dynamic,
            ratio: 1.0,
            duration: 1e-4,
            rate: 1e3,
            size: 5e-3,
            count: 100.0,
            spacing: 1e-3,
            coarsest,
            bound: Bound::Error,
            points: 1e4,
            steps: 500.0,
            cost: 1.0,
            error: 0.1,
            softening: 1e-4,
        }
    }

    fn ladder(coarsest: f64, error: Option<f64>) -> Ladder {
        Ladder::new(&plan(coarsest), error, Kind::new("brick", 2e-3, 4.0, 14.0))
    }

    #[test]
    fn coarser_solves_come_first_where_the_body_has_room_for_them() {
        let all = |mut ladder: Ladder| {
            let mut spacings = Vec::new();
            while let Some(h) = ladder.climb() {
                spacings.push(h);
            }
            spacings
        };
        assert_eq!(all(ladder(8e-3, Some(0.1))), [8e-3, 4e-3, 2e-3, 1e-3]);
        assert_eq!(all(ladder(5e-3, Some(0.1))), [5e-3, 2.5e-3, 1e-3]);
        assert_eq!(all(ladder(2.9e-3, Some(0.1))), [1e-3]);
        assert_eq!(all(ladder(1.0, None)), [1e-3]);
        assert!(all(Ladder::default()).is_empty());
    }

    #[test]
    fn a_solve_that_failed_is_followed_by_a_finer_one_and_the_last_is_final() {
        let (mut ladder, mut seen) = (ladder(5e-3, Some(0.1)), Experience::default());
        ladder.climb();
        let next = ladder.next(None, &mut seen);
        assert!(matches!(next, Next::Finer(why) if why.contains("did not come to an end")));
        ladder.climb();
        assert!(matches!(ladder.next(None, &mut seen), Next::Finer(_)));
        ladder.climb();
        assert_eq!(ladder.next(None, &mut seen), Next::Use(None));
    }

    /// A body that stays whole at that spacing.
    fn whole(spacing: f64) -> BrokenBody {
        let corner = |p: [f64; 3]| cullet_geometry::Vec3::from(p);
        let vertices = [[0.0; 3], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]].map(corner);
        let triangles = vec![[0, 2, 1], [0, 1, 3], [1, 2, 3], [0, 3, 2]];
        let mesh = cullet_geometry::TriMesh { vertices: vertices.to_vec(), triangles };
        let solid = cullet_geometry::Solid::outer(mesh);
        let (still, sheet) = (cullet_geometry::Vec3::zeros(), cullet_geometry::Sheet::default());
        let (velocity, spin) = (still, still);
        let fragment = cullet_proto::Fragment { solid, hulls: Vec::new(), velocity, spin, sheet };
        let report = cullet_proto::Report { spacing, ..Default::default() };
        BrokenBody { fragments: vec![fragment], report, ..Default::default() }
    }

    /// F23: half again as many pieces on the finer grid.
    #[test]
    fn pieces_that_come_with_the_grid_are_told() {
        let mut ladder = ladder(5e-3, Some(0.1));
        let mut seen = Experience::default();
        let mut fine = whole(1.25e-3);
        fine.fragments.push(fine.fragments[0].clone());
        ladder.next(Some(&whole(5e-3)), &mut seen);
        ladder.climb();
        let Next::Finer(why) = ladder.next(Some(&fine), &mut seen) else { panic!("not finer") };
        assert!(why.ends_with("; 1 pieces, then 2: their number is the grid's (F23)"), "{why}");
        assert_eq!(super::told(10, 14), "");
    }

    /// Three hits that stay whole on two grids: the fourth, if like them, needs but one.
    #[test]
    fn a_hit_like_others_is_taken_at_its_word() {
        let mut seen = Experience::default();
        let climbs = |speed: f64, seen: &mut Experience| {
            let kind = Kind::new("brick", 2e-3, speed, 14.0);
            let mut ladder = Ladder::new(&plan(5e-3), Some(0.1), kind);
            let mut told = Vec::new();
            while let Some(h) = ladder.climb() {
                let next = ladder.next(Some(&whole(h)), seen);
                told.push(next.clone());
                if matches!(next, Next::Use(_)) {
                    break;
                }
            }
            told
        };
        for _ in 0..3 {
            assert_eq!(climbs(4.5, &mut seen).len(), 2);
        }
        let told = climbs(5.5, &mut seen);
        let wanted = "3 hits like it had errors up to 0.00 on this grid, within 0.1";
        assert_eq!(told, [Next::Use(Some(wanted.to_owned()))]);
        // Twice as fast is another thing.
        assert_eq!(climbs(9.0, &mut seen).len(), 2);
    }
}
