//! The spacings at which one hit is solved, coarsest first: the finer one only where the coarser
//! two still differ by more than the scene allows, or where like hits did. Beyond the plan's
//! spacing only where the last two differ by more, and as far as budget and points go.

use crate::brittle::{AccuracyTarget, Figures, SolvePlan, branched, estimate};
use cullet_model::Fragmentation;
use cullet_model::outcome::{FOUND_FRAGMENTS, FOUND_LARGEST};
use cullet_world::Hit;
use std::collections::{BTreeMap, VecDeque};

/// Spacings fall by this from one solve to the next: each costs sixteen times the one before.
const STEP: f64 = 2.0;

/// Spacings over the plan's below which a coarser solve is not worth its while.
const NEAR: f64 = 1.5;

/// Hits whose errors must be known before one like them is taken at its word.
const LIKE: usize = 3;

/// Errors of spacings, as far as hits of one run have shown them; filled in the order in which jobs
/// settle, so that it is the same with any pool.
#[derive(Clone, Debug, Default)]
pub struct Experience(BTreeMap<(HitClass, u64), Vec<f64>>);

/// What makes hits alike: material, size of the body, speed and energy, in powers of two.
#[derive(Clone, Debug, Default, PartialEq, Eq, PartialOrd, Ord)]
pub struct HitClass(String, [i64; 3]);

impl HitClass {
    /// `volume` \[m³\] of the body, `speed` \[m/s\] and `energy` \[J\] of the hardest of its hits.
    #[must_use]
    pub fn new(material: &str, volume: f64, speed: f64, energy: f64) -> Self {
        let octave = |x: f64| libm::log2(x.max(f64::MIN_POSITIVE)).floor() as i64;
        Self(material.to_owned(), [volume, speed, energy].map(octave))
    }

    /// What hits of a body of `volume` \[m³\] are like: by the one of most energy.
    #[must_use]
    pub fn of(material: &str, volume: f64, hits: &[Hit]) -> Self {
        let most = |a: &&Hit, b: &&Hit| a.impact.energy.total_cmp(&b.impact.energy);
        let hardest = hits.iter().max_by(most).map(|hit| hit.impact);
        let (speed, energy) = hardest.map_or((0.0, 0.0), |i| (i.closing_speed, i.energy));
        Self::new(material, volume, speed, energy)
    }
}

impl Experience {
    fn learn(&mut self, kind: &HitClass, spacing: f64, error: f64) {
        self.0.entry((kind.clone(), spacing.to_bits())).or_default().push(error);
    }

    /// The greatest error of a spacing, and of how many hits like this one.
    fn of(&self, kind: &HitClass, spacing: f64) -> Option<(f64, usize)> {
        let known = self.0.get(&(kind.clone(), spacing.to_bits()))?;
        let greatest = known.iter().copied().fold(0.0, f64::max);
        (known.len() >= LIKE).then_some((greatest, known.len()))
    }
}

/// What follows a solve.
#[derive(Clone, Debug, PartialEq)]
pub enum Next {
    /// It is used; with why no finer one follows, where one could.
    Use(Option<String>),
    /// A finer one, because.
    Finer(String),
}

/// What is left to solve of a hit, and what the last solve came to.
#[derive(Clone, Debug, Default)]
pub struct Refinement {
    left: VecDeque<f64>,
    last: Option<Figures>,
    error: f64,
    kind: HitClass,
    reach: Option<RefinementReach>,
}

/// How far beyond the plan a hit may be solved: by planned and estimated costs, never by a clock.
#[derive(Clone, Debug)]
struct RefinementReach {
    plan: SolvePlan,
    /// Processor time that all solves of the hit may take \[s\].
    budget: f64,
    /// What those so far were reckoned to take \[s\].
    spent: f64,
    /// Spacing of the solve at hand \[m\].
    now: f64,
}

impl RefinementReach {
    /// Processor time of a solve, as h⁻⁴ \[s\].
    fn cost(&self, spacing: f64) -> f64 {
        let finer = self.plan.spacing / spacing;
        self.plan.cost * (finer * finer) * (finer * finer)
    }

    /// The next finer spacing \[m\], or why there is none.
    fn beyond(&self) -> Result<f64, String> {
        let (finest, by) = self.plan.finest;
        let left = (self.budget - self.spent).max(0.0);
        let paid = self.plan.spacing * (self.plan.cost / left).sqrt().sqrt();
        let next = (self.now / STEP).max(finest).max(paid);
        if NEAR * next <= self.now {
            return Ok(next);
        }
        Err(match paid > finest {
            true => format!("{left:.2} s of the budget's {:.2} s are left", self.budget),
            false => format!("none below {finest:.3e} m by {by}"),
        })
    }
}

impl Refinement {
    /// From the coarsest that the body bears to the plan's spacing; without an error that is good
    /// enough the plan's alone. A single coarser one would have nothing to be compared with.
    #[must_use]
    pub fn new(plan: &SolvePlan, target: &AccuracyTarget, kind: HitClass) -> Self {
        let coarser = std::iter::successors(Some(plan.coarsest), |h| Some(h / STEP));
        let coarser = coarser.take_while(|&h| target.error.is_some() && h > NEAR * plan.spacing);
        let mut left: VecDeque<f64> = coarser.collect();
        if left.len() < 2 {
            left.clear();
        }
        left.push_back(plan.spacing);
        let budget = target.budget.unwrap_or(f64::INFINITY);
        let reach = RefinementReach { plan: *plan, budget, spent: 0.0, now: plan.spacing };
        Self { left, last: None, error: target.error.unwrap_or(0.0), kind, reach: Some(reach) }
    }

    /// The next spacing \[m\]; none where no plan was made or all are done.
    pub fn climb(&mut self) -> Option<f64> {
        let spacing = self.left.pop_front()?;
        if let Some(reach) = &mut self.reach {
            reach.spent += reach.cost(spacing);
            reach.now = spacing;
        }
        Some(spacing)
    }

    /// Whether finer solves than the one at hand are planned.
    #[must_use]
    pub fn goes_on(&self) -> bool {
        !self.left.is_empty()
    }

    /// Whether an outcome is good enough, by the solve before it or by hits like this one. The
    /// plan's is, and finer ones, unless it differs from the one before it by more than the error
    /// and something is left to spend.
    pub fn next(&mut self, outcome: Option<&Fragmentation>, seen: &mut Experience) -> Next {
        let Some(now) = outcome.and_then(figures) else {
            self.last = None;
            return match self.goes_on() {
                true => Next::Finer("it did not come to an end on this grid".to_owned()),
                false => Next::Use(None),
            };
        };
        let (limit, last) = (self.error, self.last.replace(now));
        let Some(last) = last else {
            if !self.goes_on() {
                return Next::Use(None);
            }
            return match seen.of(&self.kind, now.spacing) {
                Some((error, count)) if error <= limit => Next::Use(Some(format!(
                    "{count} hits like it had errors up to {error:.2} on this grid, within {limit}"
                ))),
                Some((error, count)) => Next::Finer(format!(
                    "{count} hits like it had errors up to {error:.2} on this grid, over {limit}"
                )),
                None => Next::Finer("nothing to compare it with".to_owned()),
            };
        };
        // At first order the coarser one is that much further off.
        let error = estimate(&last, &now);
        seen.learn(&self.kind, last.spacing, error * last.spacing / now.spacing);
        seen.learn(&self.kind, now.spacing, error);
        let side = if error > limit { "over" } else { "within" };
        let pieces = told(last.count, now.count);
        let told = format!("its error is about {error:.2}, {side} {limit}{pieces}");
        match error > limit {
            true if self.goes_on() => Next::Finer(told),
            false if self.goes_on() => Next::Use(Some(told)),
            over => self.at_the_plan(over, &told),
        }
    }

    /// What follows the plan's grid, or one beyond it.
    fn at_the_plan(&mut self, over: bool, told: &str) -> Next {
        let Some(reach) = &self.reach else { return Next::Use(None) };
        let own = reach.now >= reach.plan.spacing;
        let grid = if own { "this is the plan's grid" } else { "this is finer than the plan" };
        match reach.beyond() {
            _ if !over => Next::Use(Some(format!("{grid}; {told}"))),
            Ok(spacing) => {
                self.left.push_back(spacing);
                let cost = reach.cost(spacing);
                Next::Finer(format!("{told}; finer than planned: {spacing:.3e} m, {cost:.2} s"))
            }
            Err(why) => Next::Use(Some(format!("{grid}; {told}; {why}"))),
        }
    }
}

/// What is said of pieces whose number is the grid's, after what was said.
fn told(coarse: usize, fine: usize) -> String {
    branched(coarse, fine).map_or_else(String::new, |words| format!("; {words}"))
}

/// What solves are compared by: what they found, before the scene's direction. Nothing of one
/// without a grid, which another family made.
fn figures(broken: &Fragmentation) -> Option<Figures> {
    let volumes = broken.fragments.iter().map(|part| part.solid.mesh.signed_volume());
    let whole: f64 = volumes.clone().sum();
    let largest = volumes.fold(0.0, f64::max);
    let report = &broken.report;
    let found = report.detail(FOUND_FRAGMENTS).zip(report.detail(FOUND_LARGEST));
    let (count, largest) = found
        .map_or((broken.fragments.len(), largest / whole), |(count, share)| {
            (count as usize, share)
        });
    (report.spacing > 0.0).then_some(Figures {
        spacing: report.spacing,
        crack_area: report.crack_area,
        largest,
        count,
    })
}

#[cfg(test)]
mod tests;
