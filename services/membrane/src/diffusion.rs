//! Something that a sheet takes up and that spreads in it: heat, water, acid.
//!
//! ρC h A θ̇ = Σ w (θ_j − θ_i) + sources − A ε_v (θ − θ_air), over bonds that are alive. The kernel
//! (1 − ξ/δ)/ξ² is fitted to Σ w ξ⊗ξ = 2hA K; w is positive and the same from both ends, so θ
//! stays between what it was, and its integral is kept. Han and others' Eq. 25 weighs one end only
//! and gives 0.39 of the diffusivity.

use crate::bonds::MembraneBonds;
use crate::fit::{BondRows, FactorBounds, MomentTarget, fit};
use crate::points::SheetPoints;
use cullet_continuum::bytes::{held, held_lists};
use cullet_model::{MembraneSheet, Refusal, SheetDiffusion, SheetSource, SheetSourceKind};

/// Reach over the spacing: D is within 0.1 % at 2.1, within 0.2 % at 1.6.
const REACH: f64 = 2.1;
/// No weight is negative, so that there is a maximum principle; anisotropic ones need room above.
const FACTORS: FactorBounds = FactorBounds { low: 0.1, high: 10.0 };
/// Steps of diffusion over the longest stable one.
const STEP: f64 = 0.5;

/// Straight between rows (θ, share), constant beyond them; 1 without rows.
#[must_use]
pub fn share_at(rows: &[(f64, f64)], theta: f64) -> f64 {
    let after = rows.partition_point(|(t, _)| *t <= theta);
    match (after.checked_sub(1).and_then(|k| rows.get(k)), rows.get(after)) {
        (Some(a), Some(b)) => a.1 + (b.1 - a.1) * ((theta - a.0) / (b.0 - a.0)),
        (Some(a), None) | (None, Some(a)) => a.1,
        (None, None) => 1.0,
    }
}

/// The bonds that a quantity spreads along.
#[derive(Clone, Debug)]
pub(crate) struct DiffusionBonds {
    starts: Vec<u32>,
    ends: Vec<u32>,
    /// The bond of each.
    bonds: Vec<u32>,
    /// w \[W/θ\].
    weights: Vec<f64>,
    /// Points that each source reaches.
    reached: Vec<Vec<u32>>,
    /// ρC h A \[J/θ\].
    pub(crate) capacities: Vec<f64>,
    /// Longest step that is taken \[s\].
    pub(crate) step: f64,
}

/// One step of diffusion.
#[derive(Clone, Copy, Debug)]
pub(crate) struct DiffusionStep<'a> {
    pub(crate) what: &'a SheetDiffusion,
    pub(crate) areas: &'a [f64],
    pub(crate) contacts: &'a ObjectContacts,
    /// d of each bond: nothing passes a broken one.
    pub(crate) damage: &'a [f64],
    /// Now \[s\].
    pub(crate) time: f64,
    /// Length \[s\].
    pub(crate) dt: f64,
}

/// How long rigid bodies have touched each point since a quantity's last step, by the object of the
/// scene that they are of. It is counted at every step of the sheet, so that a body that is faster
/// than the quantity's steps leaves out no point on its way.
#[derive(Clone, Debug, Default)]
pub(crate) struct ObjectContacts {
    /// Steps of the sheet that were counted.
    steps: u32,
    /// Number of each object, and the steps in which it touched each point.
    touched: Vec<(u32, Vec<PointContact>)>,
}

/// The steps in which an object touched a point.
#[derive(Clone, Copy, Debug, Default)]
struct PointContact {
    count: u32,
    /// The last of them: several bodies of an object count once.
    last: u32,
}

impl ObjectContacts {
    /// Begins to count anew.
    pub(crate) fn clear(&mut self) {
        self.steps = 0;
        for (_, touched) in &mut self.touched {
            touched.fill(PointContact::default());
        }
    }

    /// Counts a step of the sheet.
    pub(crate) fn count_step(&mut self) {
        self.steps += 1;
    }

    /// Counts that in this step a body of an object touches these points out of `count`.
    pub(crate) fn note(&mut self, object: u32, count: usize, points: impl Iterator<Item = usize>) {
        let slot = match self.touched.iter().position(|(own, _)| *own == object) {
            Some(slot) => slot,
            None => {
                self.touched.push((object, vec![PointContact::default(); count]));
                self.touched.len() - 1
            }
        };
        for point in points {
            let contact = &mut self.touched[slot].1[point];
            if contact.last != self.steps {
                *contact = PointContact { count: contact.count + 1, last: self.steps };
            }
        }
    }

    /// Share of the steps in which an object touched a point \[1\].
    fn share(&self, object: u32, point: usize) -> f64 {
        let of = |(own, touched): &(u32, Vec<PointContact>)| {
            (*own == object).then(|| f64::from(touched[point].count) / f64::from(self.steps))
        };
        self.touched.iter().find_map(of).unwrap_or(0.0)
    }
}

impl DiffusionBonds {
    /// Memory that it takes \[bytes\].
    pub(crate) fn bytes(&self) -> u64 {
        let ends = [&self.starts, &self.ends, &self.bonds].map(|list| held(list));
        let lists = held(&self.weights) + held(&self.capacities) + held_lists(&self.reached);
        ends.iter().sum::<u64>() + lists
    }

    /// # Errors
    ///
    /// If a source reaches no point, a number does not hold, or a table does not rise.
    pub(crate) fn new(
        points: &SheetPoints,
        bonds: &MembraneBonds,
        sheet: &MembraneSheet,
        what: &SheetDiffusion,
    ) -> Result<Self, Refusal> {
        check(what)?;
        let reach = REACH.min(sheet.horizon) * sheet.spacing;
        let mut found = Self {
            starts: vec![0],
            ends: Vec::new(),
            bonds: Vec::new(),
            weights: Vec::new(),
            reached: Vec::new(),
            capacities: Vec::new(),
            step: f64::INFINITY,
        };
        let mut place = vec![u32::MAX; bonds.ends.len()];
        for i in 0..points.places.len() {
            for b in bonds.of(i).filter(|&b| bonds.lengths[b] < reach) {
                place[b] = found.ends.len() as u32;
                let (j, xi) = (bonds.ends[b] as usize, bonds.lengths[b]);
                found.ends.push(j as u32);
                found.bonds.push(b as u32);
                // w ξ², which the fit works with.
                found.weights.push((1.0 - xi / reach) * (points.areas[i] * points.areas[j]));
            }
            found.starts.push(found.ends.len() as u32);
        }
        let twin = |&b: &u32| place[bonds.twins[b as usize] as usize];
        let twins: Vec<u32> = found.bonds.iter().map(twin).collect();
        found.fit(points, bonds, &twins, sheet.thickness, what);
        let capacity = |a: &f64| what.capacity * sheet.thickness * a;
        found.capacities = points.areas.iter().map(capacity).collect();
        for (number, source) in what.sources.iter().enumerate() {
            let all = 0..points.places.len() as u32;
            let reached: Vec<u32> =
                all.filter(|&i| source.region.has(points.places[i as usize])).collect();
            if reached.is_empty() {
                return Err(Refusal::Idle { what: "source", number: number + 1 });
            }
            found.reached.push(reached);
        }
        found.step = STEP * found.longest(points, what);
        Ok(found)
    }

    fn of(&self, i: usize) -> std::ops::Range<usize> {
        self.starts[i] as usize..self.starts[i + 1] as usize
    }

    fn fit(
        &mut self,
        points: &SheetPoints,
        bonds: &MembraneBonds,
        twins: &[u32],
        thickness: f64,
        what: &SheetDiffusion,
    ) {
        let own = &self.bonds;
        let basis = |n: usize| {
            let [x, y] = bonds.directions[own[n] as usize];
            [x * x, x * y, y * y]
        };
        let [kx, ky] = what.conductivity;
        let target = |i: usize| {
            let twice = 2.0 * thickness * points.areas[i];
            MomentTarget { moments: [twice * kx, 0.0, twice * ky], sum: twice * (kx + ky) }
        };
        let rows = BondRows { starts: &self.starts, twins };
        fit(rows, &mut self.weights, basis, target, FACTORS);
        for (n, w) in self.weights.iter_mut().enumerate() {
            let xi = bonds.lengths[self.bonds[n] as usize];
            *w /= xi * xi;
        }
    }

    /// The longest stable step \[s\].
    fn longest(&self, points: &SheetPoints, what: &SheetDiffusion) -> f64 {
        let mut films = vec![what.loss; points.areas.len()];
        for (source, reached) in what.sources.iter().zip(&self.reached) {
            // What touches may be anywhere in its region.
            if let SheetSourceKind::Film(_, by) | SheetSourceKind::Contact { film: by, .. } =
                source.kind
            {
                reached.iter().for_each(|&i| films[i as usize] += by);
            }
        }
        let rate = |i: usize| {
            let bonds: f64 = self.weights[self.of(i)].iter().sum();
            (bonds + films[i] * points.areas[i]) / self.capacities[i]
        };
        1.0 / (0..points.areas.len()).map(rate).fold(f64::MIN_POSITIVE, f64::max)
    }

    /// Advances θ and the exposure w by one step. Returns what came in from outside, counted as
    /// ΣρChAθ.
    pub(crate) fn advance(
        &self,
        step: DiffusionStep<'_>,
        theta: &mut [f64],
        exposure: &mut [f64],
        next: &mut Vec<f64>,
    ) -> f64 {
        let DiffusionStep { what, areas, contacts, damage, time, dt } = step;
        let mut came = 0.0;
        next.clear();
        for i in 0..theta.len() {
            let mut flow = 0.0;
            for n in self.of(i) {
                if damage[self.bonds[n] as usize] < 1.0 {
                    flow += self.weights[n] * (theta[self.ends[n] as usize] - theta[i]);
                }
            }
            let lost = areas[i] * what.loss * (theta[i] - what.ambient);
            came -= dt * lost;
            next.push(theta[i] + dt * (flow - lost) / self.capacities[i]);
        }
        let active = |source: &SheetSource| source.from <= time && time < source.until;
        for (source, reached) in what.sources.iter().zip(&self.reached) {
            for i in reached.iter().map(|&i| i as usize).filter(|_| active(source)) {
                let capacity = self.capacities[i];
                let before = next[i];
                next[i] = match source.kind {
                    SheetSourceKind::Held(value) => value,
                    SheetSourceKind::Flux(by) => before + dt * by * areas[i] / capacity,
                    SheetSourceKind::Film(towards, by) => {
                        before + dt * by * areas[i] * (towards - theta[i]) / capacity
                    }
                    SheetSourceKind::Contact { object, towards, film } => {
                        let by = film * contacts.share(object, i);
                        before + dt * by * areas[i] * (towards - theta[i]) / capacity
                    }
                };
                // What is beyond saturation runs off.
                next[i] = next[i].min(what.saturation.max(before));
                came += capacity * (next[i] - before);
            }
        }
        for (i, value) in next.iter().enumerate() {
            exposure[i] += dt * what.exposure * (value - what.start).max(0.0);
        }
        theta.copy_from_slice(next);
        came
    }

    /// ΣρChAθ.
    pub(crate) fn total(&self, theta: &[f64]) -> f64 {
        self.capacities.iter().zip(theta).map(|(c, t)| c * t).sum()
    }
}

/// That numbers and tables hold.
fn check(what: &SheetDiffusion) -> Result<(), Refusal> {
    let positive = [
        ("capacity of a sheet", what.capacity),
        ("conductivity of a sheet along x", what.conductivity[0]),
        ("conductivity of a sheet along y", what.conductivity[1]),
    ];
    let (low, high) = (1e-12, 1e12);
    for (what, value) in positive {
        if value.is_nan() || value < low || value > high {
            return Err(Refusal::OutOfRange { what, value, low, high });
        }
    }
    let finite = [what.start, what.exposure, what.weight, what.loss, what.ambient];
    let fields = finite.iter().chain(&what.expansion).all(|v| v.is_finite());
    let not_negative = what.exposure >= 0.0 && what.weight >= 0.0 && what.loss >= 0.0;
    let rises = |rows: &[(f64, f64)]| {
        let shares = rows.iter().all(|(t, q)| t.is_finite() && *q > 0.0 && *q <= 100.0);
        shares && rows.windows(2).all(|w| w[0].0 < w[1].0)
    };
    let tables = [&what.stiffness, &what.toughness, &what.strength].into_iter().all(|t| rises(t));
    let sound = |source: &SheetSource| match source.kind {
        SheetSourceKind::Held(value) | SheetSourceKind::Flux(value) => value.is_finite(),
        SheetSourceKind::Film(towards, film) | SheetSourceKind::Contact { towards, film, .. } => {
            towards.is_finite() && (0.0..=1e12).contains(&film)
        }
    };
    if let Some(number) = what.sources.iter().position(|source| !sound(source)) {
        let lack = format!("source {} of a sheet has a number that does not hold", number + 1);
        return Err(Refusal::Unfit { solver: crate::family::NAME, lack });
    }
    if !fields || !not_negative || !tables || what.saturation.is_nan() {
        let lack = "what a sheet takes up needs finite numbers, rates of at least 0, and tables \
                    whose θ rises and whose shares lie in (0, 100]";
        return Err(Refusal::Unfit { solver: crate::family::NAME, lack: lack.to_owned() });
    }
    Ok(())
}

#[cfg(test)]
mod tests;
