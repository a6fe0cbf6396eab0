//! The dicing of a toughened plate: from where it was cut through first, fronts march over it, and
//! the stress that is frozen in pays for the walls of cells behind them.
//!
//! Where and when it starts is solved. The cells are sampled: a shell knows nothing of the stress
//! that drives them (F90).

use super::ShellSolve;
use super::field::ShellField;
use super::scatter::PieceScatter;
use crate::domain::ShellDomain;
use crate::treatment::{FRONT_SPEED, WALL_SHARE, piece_width, stored_energy};
use cullet_fragment::cut::{self, CutPart, CutSettings};
use cullet_fragment::finish::{Finish, FinishedParts, FragmentMotion};
use cullet_geometry::Vec3;
use cullet_geometry::inside::Inside;
use cullet_geometry::math::{scramble, unit};
use cullet_model::{Failure, FragmentOrigin, Fragmentation};
use cullet_simd::Real;
use std::cmp::Reverse;
use std::collections::{BTreeSet, BinaryHeap};
use std::f64::consts::PI;

/// Most cells that a plate is diced into: where there are more, they are as much wider.
const MOST_CELLS: f64 = 20_000.0;

/// Share of the bodies that are single pieces where there are more pieces than bodies may be: those
/// nearest to where it starts. The others are conglomerates.
const SINGLE: f64 = 0.25;

/// How far the middles of cells are out of the midsurface at most, over the thickness: walls that
/// are all exactly upright meet in lines that no cut likes.
const UNEVEN: f64 = 0.02;

/// Median size of debris over that of a piece: most crumbling pieces are then one grain each.
const GRAIN: f64 = 2.0;

/// Stream of the seed's numbers.
const STREAM: u64 = 0xd1ce;

/// The cells of a plate that has diced.
struct DicedCells {
    scatter: PieceScatter,
    /// The body that each is of.
    labels: Vec<u32>,
    /// When the front reached each \[s\].
    times: Vec<f64>,
    /// Width of a piece by its energy \[m\].
    width: f64,
    /// How many pieces there are, by that.
    pieces: f64,
}

/// What becomes of the plate.
pub(super) fn finish<R: Real, const N: usize>(
    solve: &mut ShellSolve<R, N>,
    surface_stress: f64,
) -> Result<Fragmentation, Failure> {
    solve.check()?;
    let found = ShellField::new(solve);
    let cells = DicedCells::new(solve, surface_stress);
    let uneven = UNEVEN * solve.wall.typical;
    let lift = |k: usize| uneven * (2.0 * unit(solve.local.seed, STREAM, k as u64) - 1.0);
    let places = cells.scatter.places.iter().enumerate();
    let sites: Vec<Vec3> = places.map(|(k, place)| place + Vec3::z() * lift(k)).collect();
    let settings = CutSettings {
        min_volume_ratio: 0.0,
        max_fragments: solve.local.settings.max_fragments,
        seed: solve.local.seed,
        detail: solve.local.settings.brittle.detail,
    };
    let solid = &solve.local.solid;
    let partition = cut::by_sites(solid, &sites, &cells.labels, &cells.times, &settings)
        .map_err(|error| Failure::Cut(error.to_string()))?;
    let mut report = solve.report(&found.damage);
    report.crack_area = partition.crack_area;
    // What is frozen in pays for the walls, and nothing of the motion does.
    report.fracture_energy = 0.0;
    report.warnings.extend(partition.warnings);
    let area = solid.mesh.signed_volume() / solve.wall.typical;
    let stored = area * stored_energy(&solve.local.material, surface_stress, solve.wall.typical);
    let last = cells.times.iter().copied().fold(0.0, f64::max);
    report.warnings.push(cells.told(&partition.parts));
    let report = report
        .with("stored_energy", "J", stored)
        .with("energy_of_walls", "J", WALL_SHARE * stored)
        .with("width_of_pieces", "m", cells.width)
        .with("pieces", "1", cells.pieces)
        .with("start_of_dicing", "s", solve.record.time)
        .with("end_of_dicing", "s", last);
    let motions = motions(&found, &cells, &partition.parts);
    let pushes = solve.strikers.iter().zip(&solve.local.impacts);
    let pushes = pushes.map(|(striker, hit)| (hit.point, hit.normal * striker.delivered()));
    let supports = solve.supports.iter().map(super::contact::ShellSupport::given);
    let mut problem = solve.local.clone();
    let piece = cells.width * cells.width * solve.wall.typical;
    problem.settings.grain = problem.settings.grain.or(Some(libm::cbrt(6.0 * piece / PI) * GRAIN));
    // Cracks do not end inside pieces.
    problem.settings.brittle.hairline = None;
    let finish = Finish {
        problem: &problem,
        spacing: (solve.wall.spacing, solve.wall.spacing),
        motes: &found.motes(solve.wall.spacing),
        pushes: &pushes.chain(supports).collect::<Vec<_>>(),
    };
    let FinishedParts { fragments, debris, warnings } = finish.fragments(partition.parts, &motions);
    let mut report = report;
    report.warnings.extend(warnings);
    let reactions = solve.supports.iter().map(|one| one.given().1.norm()).collect();
    let origins = vec![FragmentOrigin::Sampled; fragments.len()];
    let fracture = Fragmentation { fragments, origins, debris, reactions, report };
    Ok(super::frame::from_local(fracture, &solve.wall.pose))
}

impl DicedCells {
    fn new<R: Real, const N: usize>(solve: &ShellSolve<R, N>, surface_stress: f64) -> Self {
        let (local, t) = (&solve.local, solve.wall.typical);
        let area = local.solid.mesh.signed_volume() / t;
        let width = piece_width(&local.material, surface_stress);
        let pieces = (area / (width * width)).max(1.0);
        let number = pieces.min(MOST_CELLS).round();
        let (low, high) = local.solid.mesh.bounds().unwrap_or_default();
        let inside = Inside::new(&local.solid.mesh);
        let apart = (area / number).sqrt();
        let seed = scramble(local.seed ^ STREAM);
        let held = |place| inside.contains(place);
        let scatter = PieceScatter::new((low, high), apart, number as usize, seed, held);
        let most = local.settings.max_fragments.max(1) as usize;
        let starts = starts(&solve.domain);
        let labels = match scatter.places.len() {
            count if count <= most => (0..count as u32).collect(),
            _ => {
                let singles = (SINGLE * most as f64) as usize;
                let clumps = most - singles;
                let apart = (area / clumps as f64).sqrt();
                let seed = scramble(seed);
                let clumps = PieceScatter::new((low, high), apart, clumps, seed, held);
                clumped(&scatter, &clumps, singles, &solve.strikers[0].patch().place)
            }
        };
        let arrival = arrivals(&solve.domain, &starts, local.material.rayleigh_speed());
        let mut times = vec![f64::INFINITY; scatter.places.len()];
        for point in solve.domain.live().filter(|&p| arrival[p].is_finite()) {
            let cell = scatter.nearest(solve.domain.surface.surface_point(point).place);
            times[cell] = times[cell].min(solve.record.time + arrival[point]);
        }
        let last =
            times.iter().copied().filter(|t| t.is_finite()).fold(solve.record.time, f64::max);
        times.iter_mut().filter(|t| !t.is_finite()).for_each(|t| *t = last);
        Self { scatter, labels, times, width, pieces }
    }

    /// What is said of them.
    fn told(&self, parts: &[CutPart]) -> String {
        let (cells, bodies) = (self.scatter.places.len(), parts.len());
        let clumps = if bodies < cells { " and conglomerates of them" } else { "" };
        format!(
            "diced: the start is solved; {:.0} pieces {:.2} mm wide are sampled by the stored \
             energy, as {bodies} pieces{clumps} (F90)",
            self.pieces,
            1e3 * self.width
        )
    }
}

/// The body that each cell is of: the `singles` nearest to a place are bodies of their own, the
/// others go with the nearest of `clumps`. All numbers up to the greatest are in use.
fn clumped(cells: &PieceScatter, clumps: &PieceScatter, singles: usize, place: &Vec3) -> Vec<u32> {
    let far = |k: usize| (cells.places[k] - place).norm_squared();
    let mut order: Vec<usize> = (0..cells.places.len()).collect();
    order.sort_by(|&a, &b| far(a).total_cmp(&far(b)).then(a.cmp(&b)));
    let mut labels = vec![0; order.len()];
    for (k, &cell) in order.iter().enumerate() {
        labels[cell] = match k < singles {
            true => clumps.places.len() + k,
            false => clumps.nearest(cells.places[cell]),
        };
    }
    let used: Vec<usize> = labels.iter().copied().collect::<BTreeSet<_>>().into_iter().collect();
    labels.iter().map(|label| used.partition_point(|other| other < label) as u32).collect()
}

/// Where it is cut through.
fn starts<R: Real, const N: usize>(domain: &ShellDomain<R, N>) -> Vec<usize> {
    let cut = |p: &usize| domain.state(*p).is_broken() || domain.state(*p).dead;
    domain.live().filter(cut).collect()
}

/// When the fronts reach each point from where they start \[s\]: on the graph of points to the
/// neighbours of neighbours, within 3 % of the straight way. Infinite where they do not get.
fn arrivals<R: Real, const N: usize>(
    domain: &ShellDomain<R, N>,
    starts: &[usize],
    rayleigh: f64,
) -> Vec<f64> {
    let surface = &domain.surface;
    let mut far = vec![f64::INFINITY; surface.points()];
    let mut next = BinaryHeap::new();
    for &start in starts {
        far[start] = 0.0;
        next.push(Reverse((0_u64, start)));
    }
    // Distances are not negative: their bits are in their order.
    while let Some(Reverse((bits, point))) = next.pop() {
        let own = f64::from_bits(bits);
        if own > far[point] {
            continue;
        }
        let place = surface.surface_point(point).place;
        let ring = surface.around(point).iter().filter(|&&q| domain.is_on(q as usize));
        for &q in ring {
            let beyond = surface.around(q as usize).iter().chain([&q]);
            for r in beyond.map(|&r| r as usize).filter(|&r| domain.is_on(r)) {
                let there = own + (surface.surface_point(r).place - place).norm();
                if there < far[r] {
                    far[r] = there;
                    next.push(Reverse((there.to_bits(), r)));
                }
            }
        }
    }
    far.into_iter().map(|far| far / (FRONT_SPEED * rayleigh)).collect()
}

/// The motion of each part: that of the points of its cells when it began to dice.
fn motions(field: &ShellField, cells: &DicedCells, parts: &[CutPart]) -> Vec<FragmentMotion> {
    let bodies = cells.labels.iter().max().map_or(0, |most| *most as usize + 1);
    let mut part_of_body = vec![u32::MAX; bodies];
    for (k, part) in parts.iter().enumerate() {
        if let Some(body) = body_of(cells, part) {
            part_of_body[body as usize] = k as u32;
        }
    }
    let of = |place: &Vec3| part_of_body[cells.labels[cells.scatter.nearest(*place)] as usize];
    let part_of: Vec<u32> = field.positions.iter().map(of).collect();
    let mut motions = field.motions(&part_of, parts.len());
    let mut empty = vec![true; parts.len()];
    part_of.iter().filter(|&&k| k != u32::MAX).for_each(|&k| empty[k as usize] = false);
    for (k, part) in parts.iter().enumerate().filter(|(k, _)| empty[*k]) {
        motions[k] =
            (field.velocity_at(&part.solid.mesh.mass_properties().centroid), Vec3::zeros());
    }
    motions
}

/// The body that a part is of: that of the cell in which most of its faces across the thickness
/// have their middles.
fn body_of(cells: &DicedCells, part: &CutPart) -> Option<u32> {
    let mesh = &part.solid.mesh;
    let mut votes: Vec<(u32, f64)> = Vec::new();
    for t in 0..mesh.triangles.len() {
        let [a, b, c] = mesh.corners(t);
        let size = (b - a).cross(&(c - a)).z.abs();
        let body = cells.labels[cells.scatter.nearest((a + b + c) / 3.0)];
        match votes.iter_mut().find(|vote| vote.0 == body) {
            Some(vote) => vote.1 += size,
            None => votes.push((body, size)),
        }
    }
    votes.into_iter().max_by(|a, b| a.1.total_cmp(&b.1).then(b.0.cmp(&a.0))).map(|vote| vote.0)
}
