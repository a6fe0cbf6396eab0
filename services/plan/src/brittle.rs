//! How finely the brittle family has to solve a hit: gates 3 to 6 and the ladder of the
//! catalogue's part 3.
//!
//! [`plan`] turns what a scene asks for (an error, a budget, a smallest fragment) and what a hit is
//! (how long, how fast, on how thick a body) into a spacing, and says in numbers which of them
//! decided. Nothing here looks at a clock: costs are reckoned, so that a plan is the same anywhere.

use crate::reason::RigidReason;
use cullet_model::Material;
use cullet_model::brittle::{AFTER_TRANSITS, CELLS_ACROSS_CHOSEN, POINTS_PER_CELL, PUSH_TRANSITS};
use cullet_world::{BodyMeasure, Hit};

/// What a scene asks of a solve.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct AccuracyTarget {
    /// Relative error of what breaks how that is good enough \[1\].
    pub error: Option<f64>,
    /// Processor time that the solves of one impact may take \[s\].
    pub budget: Option<f64>,
    /// The smallest fragment wanted \[m\].
    pub smallest: Option<f64>,
    /// What a pixel of the picture covers where the bodies are \[m\].
    pub pixel: Option<f64>,
    /// Whether the cone under the contact matters.
    pub cone: bool,
    /// Whether cracks have to start at the material's strength.
    pub strength: bool,
}

/// What of a solve the scene has already fixed.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SolveLimits {
    /// Most points \[1\].
    pub most_points: f64,
    /// Most time steps \[1\].
    pub most_steps: f64,
    /// No finer than this, which the body was last solved with \[m\].
    pub finest: f64,
}

/// How long a hit lasts beside the body's own time [Gate 3].
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Regime {
    /// Π > 5: the stress follows the force.
    Static,
    /// Waves and force are of one length in time.
    Dynamic,
    /// Π < 0.3: a wave runs through, and spalls.
    Wave,
}

/// What decided a spacing.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum SpacingBound {
    /// The scene's error.
    Error,
    /// Four cells of the smallest fragment wanted.
    Smallest,
    /// Three cells through the thickness (F14).
    Thickness,
    /// The scene's most points.
    Points,
    /// The scene's most steps.
    Steps,
    /// The scene's budget.
    Budget,
    /// The solve that made the body.
    Parent,
    /// What broke from a body is solved no finer than its own plan.
    Generation,
    /// Four cells of two pixels [Gate 0].
    Pixel,
    /// Twenty cells of the wave that the hit sends [Gate 3].
    Wave,
    /// Four cells of the contact's radius.
    Cone,
    /// The material's strength (F01).
    Strength,
}

/// What the count and the size of fragments ask for [Gate 5].
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Statistics {
    /// Fewer than two: one cut would do.
    Cut,
    /// Few enough to be solved.
    Solved,
    /// More than two hundred, smaller than the grid can tell apart: large cracks are solved, fines
    /// are drawn.
    Fines,
}

/// The planned solve of a body's hits, and its estimated cost.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SolvePlan {
    /// Statics or dynamics.
    pub regime: Regime,
    /// Π = t_c c_d / 2L \[1\].
    pub ratio: f64,
    /// Time that the solve takes in the body \[s\].
    pub duration: f64,
    /// Strain rate of the hit \[1/s\].
    pub rate: f64,
    /// Size of fragments at that rate \[m\].
    pub size: f64,
    /// How many of them the body holds, or its hit's energy pays for, if that is fewer \[1\].
    pub count: f64,
    /// Grid spacing \[m\].
    pub spacing: f64,
    /// The coarsest that the body can be solved at all \[m\].
    pub coarsest: f64,
    /// What decided the spacing.
    pub bound: SpacingBound,
    /// The finest that a solve may be where this spacing proves too coarse, and what keeps it from
    /// finer ones: all but the budget, which knows what was spent \[m\].
    pub finest: (f64, SpacingBound),
    /// Material points \[1\].
    pub points: f64,
    /// Time steps \[1\].
    pub steps: f64,
    /// Processor time \[s\].
    pub cost: f64,
    /// Relative error that the ladder reckons with \[1\].
    pub error: f64,
    /// The spacing up to which cracks start at the material's strength \[m\].
    pub softening: f64,
}

/// Processor time of a point's step, all in, of small solves in f64 \[s\]: docs/performance.md.
const POINT_STEP: f64 = 2e-7;
/// Time step over h/c_d.
const STEP: f64 = 0.4;
/// The error at twelve cells across, 30 % (ladder, L3), falls as the spacing does: 10 % at 36 (L4).
const ERROR_OF_TWELVE: f64 = 0.3;
/// Pixels across what can be seen [Gate 0].
const SEEN: f64 = 2.0;
/// Cells of the smallest fragment wanted [Gate 6].
const FRAGMENT_CELLS: f64 = 4.0;
/// More fragments than this are a matter of statistics [Gate 5].
const MANY: f64 = 200.0;
/// Cells of the length of a wave that is to run through [Gate 3].
const WAVE_CELLS: f64 = 20.0;
/// Cells of the band over which a solve spreads a crack, as F-S finds where strength gives way:
/// h_max = 0.375 l_max (docs/specimens.md).
const BAND: f64 = 0.8 / 0.375;
/// Cells of the contact's radius where the cone matters [Gate 6].
const CONE_CELLS: f64 = 4.0;
/// A body of fewer cells gets geometric pieces (ladder).
const LEAST_CELLS: f64 = 27.0;
/// Fragments that broke from a fragment are solved this much more coarsely (ladder).
const LATER: f64 = 2.0;

/// Π = t_c/(2L/c_d) and what it means [Gate 3].
#[must_use]
pub fn regime(duration: f64, length: f64, pressure_speed: f64) -> (f64, Regime) {
    let ratio = duration * pressure_speed / (2.0 * length);
    let regime = match ratio {
        r if r > 5.0 => Regime::Static,
        r if r < 0.3 => Regime::Wave,
        _ => Regime::Dynamic,
    };
    (ratio, regime)
}

/// Points of a solid of `volume` \[m³\] with so many cells through a thickness \[m\]: of a plate
/// with three, 216 (L/t)² [Gate 4].
#[must_use]
pub fn thickness_points(volume: f64, thickness: f64, cells: f64) -> f64 {
    let spacing = thickness / cells;
    POINTS_PER_CELL * volume / (spacing * spacing * spacing)
}

/// Grady's size of fragments at a strain rate \[m\], s = (24 G_f/ρε̇²)^⅓ [Gate 5].
#[must_use]
pub fn grady_size(material: &Material, rate: f64) -> f64 {
    libm::cbrt(24.0 * material.fracture_energy / (material.density * rate * rate))
}

/// How many equal pieces of a ball of `volume` \[m³\] an energy \[J\] pays for \[1\]: N of
/// ½ G_f A (N^⅓ − 1), A its surface [Gate 1].
#[must_use]
pub fn pieces_of_energy(volume: f64, energy: f64, fracture_energy: f64) -> f64 {
    let edge = 1.0 + 2.0 * energy / (fracture_energy * ball_surface(volume));
    edge * edge * edge
}

/// The surface of a ball of `volume` \[m³\], \[m²\].
fn ball_surface(volume: f64) -> f64 {
    let edge = libm::cbrt(volume);
    libm::cbrt(36.0 * std::f64::consts::PI) * edge * edge
}

/// What `count` fragments of `size` \[m\] ask of a grid of `spacing` \[m\] [Gate 5].
#[must_use]
pub fn statistics(count: f64, size: f64, spacing: f64) -> Statistics {
    if count < 2.0 {
        Statistics::Cut
    } else if count > MANY && size < FRAGMENT_CELLS * spacing {
        Statistics::Fines
    } else {
        Statistics::Solved
    }
}

/// Greatest spacing at which a crack can start at the material's strength \[m\], where one is
/// spread over a band of so many cells: 0.8 l_max/band, l_max = 2EG_f/σ_f² [Gate 6, F01].
#[must_use]
pub fn softening_spacing(material: &Material, band: f64) -> f64 {
    let strength = material.failure_stress;
    1.6 * material.young * material.fracture_energy / (strength * strength * band)
}

/// What a solve of `volume` \[m³\] over `duration` \[s\] takes at a spacing: points, steps, and
/// processor time \[s\], as h⁻⁴ [Gate 6].
#[must_use]
pub fn cost(volume: f64, duration: f64, pressure_speed: f64, spacing: f64) -> (f64, f64, f64) {
    let points = POINTS_PER_CELL * volume / (spacing * spacing * spacing);
    let steps = duration * pressure_speed / (STEP * spacing);
    (points, steps, POINT_STEP * points * steps)
}

/// Relative error of what breaks how, `across` cells through the smallest section (ladder).
#[must_use]
pub fn ladder_error(across: f64) -> f64 {
    ERROR_OF_TWELVE * 12.0 / across
}

/// How much more coarsely a body is solved that broke from another \[1\].
fn later(body: &BodyMeasure) -> f64 {
    if body.generation > 0 { LATER } else { 1.0 }
}

/// The spacings that a scene's needs ask for [Gate 6].
fn wanted(
    hit: &Hit,
    material: &Material,
    body: &BodyMeasure,
    target: &AccuracyTarget,
) -> Vec<(f64, SpacingBound)> {
    let mut wanted = Vec::new();
    wanted.extend(target.error.map(|error| {
        let cells = 12.0 * ERROR_OF_TWELVE / error;
        (later(body) * body.section.sqrt() / cells, SpacingBound::Error)
    }));
    wanted.extend(
        target.smallest.map(|d| (later(body) * d / FRAGMENT_CELLS, SpacingBound::Smallest)),
    );
    wanted.extend(target.cone.then_some((hit.impact.radius / CONE_CELLS, SpacingBound::Cone)));
    let strength = || (softening_spacing(material, BAND), SpacingBound::Strength);
    wanted.extend(target.strength.then(strength));
    wanted
}

/// The solve that a hit needs, or why geometric pieces are all that it is worth.
///
/// # Errors
/// The reason, with its bound.
pub fn plan(
    hit: &Hit,
    material: &Material,
    body: &BodyMeasure,
    target: &AccuracyTarget,
    limits: &SolveLimits,
) -> Result<SolvePlan, RigidReason> {
    let (pressure, shear) = (material.pressure_speed(), material.shear_speed());
    let (ratio, regime) = regime(hit.impact.duration, body.length, pressure);
    let transit = body.length / shear;
    let duration = hit.impact.duration.min(PUSH_TRANSITS * transit) + AFTER_TRANSITS * transit;
    // ε̇ ≈ v/max(a, L_c)  [Gate 5]
    let rate = hit.impact.closing_speed / hit.impact.radius.max(body.thickness);
    let size = grady_size(material, rate);
    let paid = pieces_of_energy(body.volume, hit.impact.energy, material.fracture_energy);
    let count = (body.volume / (size * size * size)).min(paid);
    let across = body.section.sqrt();
    if let Some(limit) = target.pixel.map(|p| SEEN * p).filter(|&limit| 0.5 * across < limit) {
        return Err(RigidReason::Unseen { size: 0.5 * across, limit });
    }
    let most = libm::cbrt(POINTS_PER_CELL * body.volume / limits.most_points);
    let mut wanted = wanted(hit, material, body, target);
    if wanted.is_empty() {
        wanted.push((later(body) * most, SpacingBound::Points));
    }
    let bending = body.depth / CELLS_ACROSS_CHOSEN;
    wanted.push((bending, SpacingBound::Thickness));
    if regime == Regime::Wave {
        wanted.push((hit.impact.duration * pressure / WAVE_CELLS, SpacingBound::Wave));
    }
    let finest = |a: (f64, SpacingBound), b: (f64, SpacingBound)| if b.0 < a.0 { b } else { a };
    let spacing = wanted.into_iter().fold((f64::INFINITY, SpacingBound::Points), finest);
    let (_, steps, unit) = cost(body.volume, duration, pressure, 1.0);
    let budget = target.budget.map(|budget| ((unit / budget).sqrt().sqrt(), SpacingBound::Budget));
    let pixel = target.pixel.map(|pixel| (SEEN * pixel / FRAGMENT_CELLS, SpacingBound::Pixel));
    let coarsest = |a: (f64, SpacingBound), b: (f64, SpacingBound)| if b.0 > a.0 { b } else { a };
    let rest =
        [(limits.finest, SpacingBound::Parent), (steps / limits.most_steps, SpacingBound::Steps)];
    let floor = rest.into_iter().chain(pixel).fold((most, SpacingBound::Points), coarsest);
    let (spacing, bound) = [floor].into_iter().chain(budget).fold(spacing, coarsest);
    let finest = if body.generation > 0 { (spacing, SpacingBound::Generation) } else { floor };
    let cells = body.volume / (spacing * spacing * spacing);
    if cells < LEAST_CELLS {
        return Err(RigidReason::Cells { cells, limit: LEAST_CELLS, spacing });
    }
    if spacing > bending * (1.0 + 1e-9) {
        let cells = body.depth / spacing;
        let points = thickness_points(body.volume, body.depth, CELLS_ACROSS_CHOSEN);
        return Err(RigidReason::Thin { cells, limit: CELLS_ACROSS_CHOSEN, spacing, points });
    }
    let (points, steps, cost) = cost(body.volume, duration, pressure, spacing);
    let error = ladder_error(across / spacing);
    Ok(SolvePlan {
        regime,
        ratio,
        duration,
        rate,
        size,
        count,
        spacing,
        coarsest: bending.min(libm::cbrt(body.volume / LEAST_CELLS)),
        bound,
        finest,
        points,
        steps,
        cost,
        error,
        softening: softening_spacing(material, BAND),
    })
}

impl std::fmt::Display for SpacingBound {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.write_str(match self {
            Self::Error => "the error asked for",
            Self::Smallest => "the smallest fragment wanted",
            Self::Thickness => "the thickness",
            Self::Points => "the most points",
            Self::Steps => "the most steps",
            Self::Budget => "the budget",
            Self::Parent => "the solve that made it",
            Self::Generation => "its generation",
            Self::Pixel => "the pixel",
            Self::Wave => "the wave's length",
            Self::Cone => "the contact's radius",
            Self::Strength => "the strength",
        })
    }
}

impl std::fmt::Display for SolvePlan {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        let regime = match self.regime {
            Regime::Static => "static",
            Regime::Dynamic => "dynamic",
            Regime::Wave => "a wave",
        };
        write!(
            f,
            "{regime}, the push takes {:.2} of a wave's way there and back, and some {:.2e} s are \
             solved; {:.2e} /s ask for {:.1} pieces of {:.2e} m; spacing {:.3e} m by {}: \
             {:.0} points, {:.0} steps, {:.2} s, error {:.2}",
            self.ratio,
            self.duration,
            self.rate,
            self.count,
            self.size,
            self.spacing,
            self.bound,
            self.points,
            self.steps,
            self.cost,
            self.error,
        )?;
        match statistics(self.count, self.size, self.spacing) {
            Statistics::Cut => f.write_str("; one cut would do")?,
            Statistics::Fines => f.write_str("; fines are drawn, not solved")?,
            Statistics::Solved => {}
        }
        if self.spacing > self.softening * (1.0 + 1e-9) {
            write!(f, "; toughness-controlled: strength alone asks for {:.3e} m", self.softening)?;
        }
        Ok(())
    }
}

/// How far two solves of one hit differ, the finer one's figures as the measure: crack area and the
/// share of the largest fragment.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Figures {
    /// Spacing \[m\].
    pub spacing: f64,
    /// Crack area \[m²\].
    pub crack_area: f64,
    /// Share of the volume in the largest fragment \[1\].
    pub largest: f64,
    /// Fragments.
    pub count: usize,
}

/// Estimate of the finer solve's relative error from a coarser one, at first order:
/// GCI = 1.25 |q₁ − q₂| / (r − 1) |q₁| of the figure that differs most.
#[must_use]
pub fn estimate(coarse: &Figures, fine: &Figures) -> f64 {
    let refined = coarse.spacing / fine.spacing - 1.0;
    let gci = |one: f64, two: f64| {
        let scale = two.abs().max(one.abs());
        if scale > 0.0 {
            1.25 * (one - two).abs() / (refined * two.abs().max(1e-3 * scale))
        } else {
            0.0
        }
    };
    gci(coarse.crack_area, fine.crack_area).max(gci(coarse.largest, fine.largest))
}

/// Where a finer grid makes half again as many pieces as the one before it, or as few, their number
/// is the grid's (F23): what is to be said of that.
#[must_use]
pub fn branched(coarse: usize, fine: usize) -> Option<String> {
    let (few, many) = (coarse.min(fine), coarse.max(fine));
    (2 * many >= 3 * few)
        .then(|| format!("{coarse} pieces, then {fine}: their number is the grid's (F23)"))
}

/// [`plan`] for the hits of one body: the finest that any of them needs; `None` of no hits.
#[must_use]
pub fn finest(
    hits: &[Hit],
    material: &Material,
    body: &BodyMeasure,
    target: &AccuracyTarget,
    limits: &SolveLimits,
) -> Option<Result<SolvePlan, RigidReason>> {
    let plans = hits.iter().map(|hit| plan(hit, material, body, target, limits));
    plans.reduce(|one, two| match (one, two) {
        (Ok(one), Ok(two)) => Ok(if two.spacing < one.spacing { two } else { one }),
        (Err(_), other) | (other, Err(_)) => other,
    })
}
