//! A broken look at the price of a diagram: Voronoi cells around the impact, as many as the energy
//! can pay for and the rate of strain asks for; radials and rings where a plate is hit on its face.
//! Of its strength only scored lines count: cracks lie on them. The pattern is not caused by
//! stress; volume, mass, momentum and the energy bound are kept.

mod held;
mod probes;
mod scored;
#[cfg(test)]
mod tests;
mod web;

use cullet_fragment::cut::{CutError, CutPart, CutSettings, Cutting, Partition};
use cullet_fragment::motion::balance;
use cullet_geometry::{MassProperties, Sheet, Vec3};
use cullet_model::outcome::{DELIVERED_IMPULSE, STRENGTH_RATIO};
use cullet_model::{
    BrittleProblem, Cost, Failure, Fragment, FragmentOrigin, Fragmentation, Impact, PointPrecision,
    Problem, Progress, Refusal, Report, Solver,
};
use probes::{PROBES, Probes};
use scored::{ScoredLines, ScoredSites};

/// Share of the approach energy that goes into new surface. Ladder runs give 0.05 to 0.3; the rest
/// is heat, sound and motion.
const SURFACE_SHARE: f64 = 0.1;
/// Patterns with fewer and fewer cells are tried this often before the body is left whole.
const TRIES: u32 = 12;
/// Diagrams tried, each with sites shaken anew, before a cut is given up.
const ATTEMPTS: u64 = 3;

/// Impact-centred Voronoi cells. Fragments move as the unbroken body would after the same hits,
/// v = J/m + ω × r with ω = I⁻¹ Σ r_J × J: that keeps momentum exactly, and adds nothing to it.
/// Those that lie on a support are stopped by it.
#[derive(Debug)]
pub struct Geometric {
    problem: BrittleProblem,
    body: MassProperties,
    /// Where cells may be, the most important first \[m\].
    sites: Vec<Vec3>,
    /// How many of them are used: at first, and now.
    first_count: usize,
    count: usize,
    /// The scored lines that cracks keep to.
    lines: Option<ScoredLines>,
    cutting: Option<Cutting>,
    attempt: u64,
    tries: u32,
    warnings: Vec<String>,
}

impl Solver for Geometric {
    const NAME: &'static str = "geometric";
    const PRECISIONS: &'static [PointPrecision] = &[PointPrecision::Single, PointPrecision::Double];

    fn accepts(problem: &Problem) -> Result<Cost, Refusal> {
        let problem = &BrittleProblem::of(problem.clone(), Self::NAME)?;
        check_body(problem)?;
        in_range("number of impacts", problem.impacts.len() as f64, 1.0, f64::MAX)?;
        problem.impacts.iter().try_for_each(check_impact)?;
        let triangles = problem.solid.mesh.triangles.len() as f64;
        // Regions and pieces: some hundred bytes for each of their triangles, of which the body's
        // are about as many again as the cells'.
        let cells = f64::from(problem.settings.max_fragments.max(1));
        let bytes = 1e3 * triangles + 1e5 * cells + 100.0 * PROBES;
        Ok(Cost { particles: 0.0, steps: 0.0, bytes })
    }

    fn begin(problem: Problem) -> Result<Self, Refusal> {
        Self::accepts(&problem)?;
        let problem = BrittleProblem::of(problem, Self::NAME)?;
        let body = problem.solid.mesh.mass_properties();
        let probes = Probes::new(&problem, body.volume);
        let mut sites = probes.sites(&problem);
        let energy: f64 = problem.impacts.iter().map(|impact| impact.energy).sum();
        let affordable = SURFACE_SHARE * energy / problem.material.fracture_energy;
        let most = sites.len().min(problem.settings.max_fragments as usize);
        let most = most.min(dynamic_count(&problem, &body));
        if let Some(web) = web::sites(&problem, most) {
            sites = web;
        }
        let most = most.min(sites.len());
        let mut count = probes.most_sites(&sites[..most], affordable);
        if count < 2
            && most >= 2
            && let Some(mate) = probes.cheap_mate(&sites, affordable)
        {
            sites.swap(1, mate);
            count = 2;
        }
        let mut warnings = Vec::new();
        if sites.len() < 2 {
            warnings.push("the body is too thin to be probed: left whole".to_owned());
        }
        let scored = problem.strength.scored(0.0);
        let lines = ScoredLines::of(&scored, &problem.solid.mesh, problem.seed);
        let (attempt, tries) = (0, 0);
        Ok(Self {
            problem,
            body,
            sites,
            first_count: count,
            count,
            lines,
            cutting: None,
            attempt,
            tries,
            warnings,
        })
    }

    fn advance(&mut self) -> Progress {
        match self.slice() {
            Ok(progress) => progress,
            Err(_) if self.attempt + 1 < ATTEMPTS => {
                self.attempt += 1;
                self.cutting = None;
                Progress::Running(0.0)
            }
            Err(error) if self.lines.is_some() => {
                self.leave_lines(&error.to_string());
                Progress::Running(0.0)
            }
            Err(error) => Progress::Failed(Failure::Cut(error.to_string())),
        }
    }
}

impl Geometric {
    fn slice(&mut self) -> Result<Progress, CutError> {
        let Some(cutting) = &mut self.cutting else {
            let cutting = self.cut()?;
            self.cutting = Some(cutting);
            return Ok(Progress::Running(0.0));
        };
        let Some(partition) = cutting.step()? else {
            return Ok(Progress::Running(cutting.share()));
        };
        let energy: f64 = self.problem.impacts.iter().map(|impact| impact.energy).sum();
        let needed = partition.crack_area * self.problem.material.fracture_energy;
        if needed > energy {
            self.have_fewer_cells();
            return Ok(Progress::Running(0.0));
        }
        Ok(Progress::Done(self.fracture(partition).into()))
    }

    /// What the energy did not pay for is tried with fewer cells; where even two along the scored
    /// lines cost too much, without the lines.
    fn have_fewer_cells(&mut self) {
        self.cutting = None;
        self.tries += 1;
        self.count = if self.tries < TRIES { self.count * 2 / 3 } else { 1 };
        if self.count < 2 && self.lines.is_some() {
            self.leave_lines("the energy does not pay for cracks along them");
        }
    }

    /// Begins anew as if the body had no scored lines.
    fn leave_lines(&mut self, why: &str) {
        self.warnings.push(format!("scored lines are passed over: {why}"));
        self.lines = None;
        self.cutting = None;
        (self.attempt, self.tries, self.count) = (0, 0, self.first_count);
    }

    fn cut(&self) -> Result<Cutting, CutError> {
        let settings = CutSettings {
            min_volume_ratio: self.problem.settings.min_volume_ratio,
            max_fragments: self.problem.settings.max_fragments,
            seed: self.problem.seed,
            detail: self.problem.settings.brittle.detail,
        };
        let cells = self.cells();
        let (count, ScoredSites { sites, labels }) = (cells.count(), cells);
        let times = vec![0.0; sites.len()];
        let solid = &self.problem.solid;
        Cutting::begin(solid, &sites, &labels, &times, count, &settings, self.attempt)
    }

    /// The sites of the cells. Where lines part more of them than there may be fragments, which
    /// would be joined again across lines, there are fewer.
    fn cells(&self) -> ScoredSites {
        let mut count = self.count;
        if count < 2 {
            // One cell is the whole body, wherever its site is.
            return ScoredSites::plain(vec![self.body.centroid]);
        }
        let Some(lines) = &self.lines else {
            return ScoredSites::plain(self.sites[..count].to_vec());
        };
        let most = self.problem.settings.max_fragments as usize;
        loop {
            let cells = lines.along(&self.sites[..count]);
            if cells.count() <= most || count == 1 {
                return cells;
            }
            count = (count * most / cells.count()).max(1);
        }
    }

    fn fracture(&mut self, partition: Partition) -> Fragmentation {
        let motion =
            BodyMotion::new(&self.problem.impacts, &self.body, self.problem.material.density);
        let crack_area = partition.crack_area;
        let fracture_energy = crack_area * self.problem.material.fracture_energy;
        let mut warnings = std::mem::take(&mut self.warnings);
        warnings.extend(partition.warnings);
        let report = Report {
            solver: Self::NAME.to_owned(),
            crack_area,
            fracture_energy,
            dissipated_energy: fracture_energy,
            warnings,
            ..Default::default()
        }
        .with(STRENGTH_RATIO, "1", 1.0)
        .with(DELIVERED_IMPULSE, "N·s", self.problem.impacts.iter().map(delivered).sum());
        let mut fragments: Vec<Fragment> =
            partition.parts.into_iter().map(|part| motion.carry(part)).collect();
        let reactions = self.hold(&mut fragments);
        // Where nothing parted there is nothing that was sampled.
        let origin = FragmentOrigin::of_sampled(fragments.len() > 1);
        let origins = vec![origin; fragments.len()];
        Fragmentation { fragments, origins, reactions, report, ..Fragmentation::default() }
    }

    /// Lets the supports stop what lies on them; what the pieces have in all is then what the hits
    /// and the supports gave.
    fn hold(&self, fragments: &mut [Fragment]) -> Vec<f64> {
        let BrittleProblem { impacts, supports, material, .. } = &self.problem;
        let reactions = held::stop(fragments, supports, material.density);
        if reactions.iter().any(|&impulse| impulse > 0.0) {
            let hits = impacts.iter().map(|hit| (hit.point, hit.normal * delivered(hit)));
            let held = supports.iter().zip(&reactions).map(|(s, &j)| (s.point, s.normal * j));
            let pushes: Vec<(Vec3, Vec3)> = hits.chain(held).collect();
            balance(fragments, &pushes, material.density);
        }
        reactions
    }
}

/// The most fragments that the rate of strain allows: the momentum of a fragment larger than
/// Grady's size tears it apart, a smaller one has too little to do so. With a thickness t below
/// that size, fragments are slabs. A body smaller than that size stays whole.
fn dynamic_count(problem: &BrittleProblem, body: &MassProperties) -> usize {
    let material = &problem.material;
    let length = libm::cbrt(body.volume);
    let speed = problem.impacts.iter().map(|i| i.closing_speed).fold(0.0, f64::max);
    let rate = speed / length;
    // s = (24 G_f / ρ ε̇²)^⅓  [Grady 1982]
    let size = libm::cbrt(24.0 * material.fracture_energy / (material.density * rate * rate));
    let thickness = 2.0 * body.volume / problem.solid.mesh.area();
    let count = body.volume / (size * size * size.min(thickness));
    // A rate of zero gives a size beyond all bounds, and a count of zero or NaN.
    if count >= 1.0 { count.ceil().max(2.0) as usize } else { 1 }
}

/// What a hit gives to a body that breaks \[N·s\]: no more than ends the approach, m* v = 2E/v. The
/// pieces do not throw the striker back.
fn delivered(impact: &Impact) -> f64 {
    impact.impulse.min(2.0 * impact.energy / impact.closing_speed)
}

/// The rigid motion that the hits give to the whole body.
struct BodyMotion {
    centroid: Vec3,
    velocity: Vec3,
    spin: Vec3,
}

impl BodyMotion {
    fn new(impacts: &[Impact], body: &MassProperties, density: f64) -> Self {
        let (mut push, mut turn) = (Vec3::zeros(), Vec3::zeros());
        for impact in impacts {
            let impulse = impact.normal * delivered(impact);
            push += impulse;
            turn += (impact.point - body.centroid).cross(&impulse);
        }
        // A body with volume has an invertible inertia; one that rounds to none does not turn.
        let inverse = (body.inertia * density).try_inverse().unwrap_or_default();
        Self {
            centroid: body.centroid,
            velocity: push / (density * body.volume),
            spin: inverse * turn,
        }
    }

    fn carry(&self, part: CutPart) -> Fragment {
        let arm = part.solid.mesh.mass_properties().centroid - self.centroid;
        Fragment {
            solid: part.solid,
            hulls: part.hulls,
            velocity: self.velocity + self.spin.cross(&arm),
            spin: self.spin,
            sheet: Sheet::default(),
        }
    }
}

fn check_body(problem: &BrittleProblem) -> Result<(), Refusal> {
    const LEAST: f64 = f64::MIN_POSITIVE;
    let mesh = &problem.solid.mesh;
    in_range("triangles of the body", mesh.triangles.len() as f64, 4.0, f64::from(u32::MAX))?;
    finite("a coordinate of the body", mesh.vertices.iter().flatten())?;
    in_range("volume of the body [m³]", mesh.signed_volume(), LEAST, f64::MAX)?;
    in_range("density [kg/m³]", problem.material.density, LEAST, f64::MAX)?;
    in_range("fracture energy [J/m²]", problem.material.fracture_energy, LEAST, f64::MAX)
}

fn check_impact(impact: &Impact) -> Result<(), Refusal> {
    finite("an impact's place", impact.point.iter().chain(impact.normal.iter()))?;
    in_range("impulse [N·s]", impact.impulse, 0.0, f64::MAX)?;
    in_range("energy [J]", impact.energy, 0.0, f64::MAX)?;
    in_range("contact radius [m]", impact.radius, 0.0, f64::MAX)
}

fn finite<'a>(
    what: &'static str,
    mut values: impl Iterator<Item = &'a f64>,
) -> Result<(), Refusal> {
    match values.find(|x| !x.is_finite()) {
        Some(&value) => Err(out_of_range(what, value, f64::MIN, f64::MAX)),
        None => Ok(()),
    }
}

fn in_range(what: &'static str, value: f64, low: f64, high: f64) -> Result<(), Refusal> {
    if value >= low && value <= high { Ok(()) } else { Err(out_of_range(what, value, low, high)) }
}

fn out_of_range(what: &'static str, value: f64, low: f64, high: f64) -> Refusal {
    Refusal::OutOfRange { what, value, low, high }
}
