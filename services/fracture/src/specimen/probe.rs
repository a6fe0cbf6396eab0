//! What is watched, and reading it off the body.

use super::build::Frame;
use super::run::Books;
use super::{Where, within};
use crate::mpm::Domain;
use crate::mpm::domain::PointMotion;
use crate::mpm::symmetric::{Sym3, eigen};
use cullet_geometry::{Mat3, Vec3};
use std::collections::BTreeMap;

/// Pitch of the squares that count the area of a crack, in spacings.
const SQUARE: f64 = 1.0;

/// What points carry.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Field {
    /// Displacement \[m\].
    Displacement,
    /// Velocity \[m/s\].
    Velocity,
    /// Second Piola–Kirchhoff stress, as weakened \[Pa\]; that of Cauchy where strains are small.
    Stress,
    /// Green's strain \[1\].
    Strain,
    /// Damage \[1\].
    Damage,
}

/// One number of a vector or of a symmetric tensor, in the specimen's frame.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Part {
    /// A component of a vector: 0, 1, 2.
    Axis(usize),
    /// A component of a tensor: xx, yy, zz, xy, yz, zx.
    Pair(usize),
    /// Length of a vector, or norm of a tensor.
    Size,
    /// Greatest principal value.
    Greatest,
    /// Least principal value.
    Least,
    /// Von Mises' equivalent, √(3/2) of the deviator's norm.
    Mises,
    /// A third of the trace.
    Mean,
}

/// Where points are looked at.
#[derive(Clone, Debug, PartialEq)]
pub enum Spot {
    /// The point nearest to a place; displacement and velocity go on in a straight line from it
    /// \[m\].
    At(Vec3),
    /// All points of a part.
    Over(Where, Reduce),
}

/// What becomes of the numbers of many points.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Reduce {
    /// Their mean by volume.
    Mean,
    /// The greatest.
    Max,
    /// The least.
    Min,
}

/// One number that is sampled in time.
#[derive(Clone, Debug, PartialEq)]
pub enum Probe {
    /// Of the points' fields.
    Points(Field, Part, Spot),
    /// Force of a support on the body \[N\].
    Reaction(usize, Part),
    /// A load's force \[N\].
    Applied(usize, Part),
    /// Kinetic energy \[J\].
    Kinetic,
    /// Elastic energy \[J\].
    Elastic,
    /// Energy lost to damage \[J\].
    Dissipated,
    /// Energy that damping took \[J\].
    Damped,
    /// Energy lost where sides of cracks, or bodies, met \[J\].
    Met,
    /// Work of loads and supports \[J\].
    Work,
    /// Energy that is there or was lost in a known way, less what was put in \[J\].
    Balance,
    /// Linear momentum \[kg·m/s\].
    Momentum(Part),
    /// Angular momentum about the specimen's origin \[kg·m²/s\].
    AngularMomentum(Part),
    /// Fully broken points of a part \[1\].
    Broken(Where),
    /// Volume of the points of a part whose damage is above a bound \[m³\].
    DamagedVolume(Where, f64),
    /// Area of the squares of one spacing, across a direction, that broken points of a part lie in
    /// \[m²\].
    CrackArea(Where, Vec3),
    /// How far broken points of a part reach along a direction \[m\]; without any, `otherwise`.
    CrackTip {
        /// Which points.
        part: Where,
        /// Unit direction.
        along: Vec3,
        /// Share of the points that lie behind \[1\].
        share: f64,
        /// Before there are any \[m\].
        otherwise: f64,
    },
    /// Angle of the mean of a part's broken points about a place, from a first direction towards a
    /// second \[rad\]; not a number without any.
    CrackAngle(Where, Vec3, [Vec3; 2]),
    /// Pieces of at least a share of the body \[1\].
    Pieces(f64),
    /// The largest piece's share of the body \[1\].
    Largest,
}

/// What is read off a body at one time.
pub(super) struct Reading<'a> {
    pub(super) domain: &'a Domain,
    pub(super) frame: &'a Frame,
    pub(super) books: &'a Books,
    /// Where the points of the body are in the specimen.
    pub(super) places: &'a [Vec3],
    motions: Vec<PointMotion>,
    stresses: Vec<Sym3>,
}

impl<'a> Reading<'a> {
    pub(super) fn new(
        domain: &'a Domain,
        frame: &'a Frame,
        books: &'a Books,
        places: &'a [Vec3],
        stress: bool,
    ) -> Self {
        let stresses = if stress { domain.stresses() } else { Vec::new() };
        Self { domain, frame, books, places, motions: domain.motions(), stresses }
    }

    pub(super) fn value(&self, probe: &Probe) -> f64 {
        match probe {
            Probe::Points(field, part, spot) => self.points(*field, *part, spot),
            Probe::Reaction(hold, part) => vector_part(&self.books.reactions[*hold], *part),
            Probe::Applied(load, part) => vector_part(&self.books.applied[*load], *part),
            Probe::Kinetic => self.domain.kinetic_energy(),
            Probe::Elastic => self.domain.elastic_energy(),
            Probe::Dissipated => self.books.dissipated,
            Probe::Damped => self.books.damped,
            Probe::Met => self.books.met,
            Probe::Work => self.books.work,
            Probe::Balance => self.books.balance(self.domain),
            Probe::Momentum(part) => {
                vector_part(&self.frame.unturned(&self.domain.momentum()), *part)
            }
            Probe::AngularMomentum(part) => {
                let origin = self.frame.onto(&Vec3::zeros());
                let about = self.domain.angular_momentum() - origin.cross(&self.domain.momentum());
                vector_part(&self.frame.unturned(&about), *part)
            }
            Probe::Broken(part) => self.broken(part).count() as f64,
            Probe::DamagedVolume(part, bound) => self.damaged(part, *bound),
            Probe::CrackArea(part, normal) => self.crack_area(part, normal),
            Probe::CrackTip { part, along, share, otherwise } => {
                self.tip(part, along, *share).unwrap_or(*otherwise)
            }
            Probe::CrackAngle(part, about, [first, second]) => {
                let sum: Vec3 = self.broken(part).map(|p| self.places[p] - about).sum();
                let some = sum.norm_squared() > 0.0;
                let angle = libm::atan2(sum.dot(second), sum.dot(first));
                if some { angle } else { f64::NAN }
            }
            Probe::Pieces(share) => {
                self.pieces().iter().filter(|&&piece| piece >= *share).count() as f64
            }
            Probe::Largest => self.pieces().first().copied().unwrap_or(0.0),
        }
    }

    /// One number of one point; `ahead` is how far from it to look \[m\].
    pub(super) fn at(&self, p: usize, field: Field, part: Part, ahead: &Vec3) -> f64 {
        let motion = &self.motions[p];
        let ahead = self.frame.turned(ahead);
        match field {
            Field::Displacement => {
                let u = motion.displacement + motion.displacement_gradient * ahead;
                vector_part(&self.frame.unturned(&u), part)
            }
            Field::Velocity => {
                let v = motion.velocity + motion.velocity_gradient * ahead;
                vector_part(&self.frame.unturned(&v), part)
            }
            Field::Stress => self.tensor_part(&self.stresses[p], part),
            Field::Strain => {
                let strain = crate::mpm::elastic::green_strain(&motion.displacement_gradient);
                self.tensor_part(&strain, part)
            }
            Field::Damage => self.domain.particles.damage[p],
        }
    }

    fn points(&self, field: Field, part: Part, spot: &Spot) -> f64 {
        match spot {
            Spot::At(x) => {
                let far = |p: usize| (self.places[p] - x).norm_squared();
                let ids = &self.domain.particles.id;
                let nearest = (0..self.places.len())
                    .min_by(|&a, &b| far(a).total_cmp(&far(b)).then(ids[a].cmp(&ids[b])));
                nearest.map_or(f64::NAN, |p| self.at(p, field, part, &(x - self.places[p])))
            }
            Spot::Over(region, reduce) => {
                let taken =
                    (0..self.places.len()).filter(|&p| within(region, &self.places[p], 0.0));
                let none = Vec3::zeros();
                let values = taken.map(|p| (self.at(p, field, part, &none), p));
                // No number among them, or no point: no number.
                match reduce {
                    Reduce::Max => most(values.map(|v| v.0)),
                    Reduce::Min => -most(values.map(|v| -v.0)),
                    Reduce::Mean => {
                        let volume = &self.domain.particles.volume;
                        let add = |(sum, all): (f64, f64), (value, p): (f64, usize)| {
                            (sum + value * volume[p], all + volume[p])
                        };
                        let (sum, all) = values.fold((0.0, 0.0), add);
                        sum / all
                    }
                }
            }
        }
    }

    fn tensor_part(&self, s: &Sym3, part: Part) -> f64 {
        let trace = s[0] + s[1] + s[2];
        let square = |s: &Sym3| {
            let shear = s[3] * s[3] + s[4] * s[4] + s[5] * s[5];
            s[0] * s[0] + s[1] * s[1] + s[2] * s[2] + 2.0 * shear
        };
        match part {
            Part::Mean => trace / 3.0,
            Part::Size => square(s).sqrt(),
            Part::Mises => (1.5 * (square(s) - trace * trace / 3.0).max(0.0)).sqrt(),
            Part::Greatest => eigen(s).0.into_iter().fold(f64::NEG_INFINITY, f64::max),
            Part::Least => eigen(s).0.into_iter().fold(f64::INFINITY, f64::min),
            Part::Pair(_) | Part::Axis(_) => {
                let (Part::Pair(k) | Part::Axis(k)) = part else { return f64::NAN };
                let m = Mat3::new(s[0], s[3], s[5], s[3], s[1], s[4], s[5], s[4], s[2]);
                let (i, j) = [(0, 0), (1, 1), (2, 2), (0, 1), (1, 2), (2, 0)][k.min(5)];
                let axis = |a: usize| self.frame.turned(&Vec3::ith(a, 1.0));
                axis(i).dot(&(m * axis(j)))
            }
        }
    }

    fn broken<'b>(&'b self, part: &'b Where) -> impl Iterator<Item = usize> + 'b {
        let damage = &self.domain.particles.damage;
        (0..self.places.len())
            .filter(move |&p| damage[p] >= 1.0 && within(part, &self.places[p], 0.0))
    }

    fn damaged(&self, part: &Where, bound: f64) -> f64 {
        let particles = &self.domain.particles;
        let taken = (0..self.places.len())
            .filter(|&p| particles.damage[p] > bound && within(part, &self.places[p], 0.0));
        taken.map(|p| particles.volume[p]).sum()
    }

    fn crack_area(&self, part: &Where, normal: &Vec3) -> f64 {
        let pitch = SQUARE * self.domain.grid.spacing.max();
        let u = normal.cross(&Vec3::ith(normal.iamin(), 1.0)).normalize();
        let v = normal.cross(&u);
        let mut squares: Vec<(i64, i64)> = self
            .broken(part)
            .map(|p| {
                let x = &self.places[p];
                ((x.dot(&u) / pitch).floor() as i64, (x.dot(&v) / pitch).floor() as i64)
            })
            .collect();
        squares.sort_unstable();
        squares.dedup();
        squares.len() as f64 * pitch * pitch
    }

    fn tip(&self, part: &Where, along: &Vec3, share: f64) -> Option<f64> {
        let mut reach: Vec<f64> = self.broken(part).map(|p| self.places[p].dot(along)).collect();
        reach.sort_unstable_by(f64::total_cmp);
        let last = reach.len().checked_sub(1)?;
        Some(reach[(share * last as f64).round() as usize])
    }

    /// Shares of the body by falling size.
    pub(super) fn pieces(&self) -> Vec<f64> {
        shares(self.domain)
    }
}

/// The greatest; no number if one of them is none, or there are none.
fn most(values: impl Iterator<Item = f64>) -> f64 {
    let greater = |m: f64, v: f64| if m.is_nan() || v <= m { m } else { v };
    values.reduce(greater).unwrap_or(f64::NAN)
}

/// Shares of the body's mass that its pieces have, by their whole points, the largest first.
pub(super) fn shares(domain: &Domain) -> Vec<f64> {
    let particles = &domain.particles;
    let mut sizes: BTreeMap<u32, f64> = BTreeMap::new();
    for (id, piece) in domain.pieces().into_iter().enumerate() {
        if let Some(piece) = piece {
            *sizes.entry(piece).or_default() += particles.mass(domain.slot(id as u32));
        }
    }
    let all: f64 = (0..particles.volume.len()).map(|p| particles.mass(p)).sum();
    let mut shares: Vec<f64> = sizes.into_values().map(|size| size / all).collect();
    shares.sort_unstable_by(|a, b| b.total_cmp(a));
    shares
}

fn vector_part(v: &Vec3, part: Part) -> f64 {
    match part {
        Part::Axis(k) => v[k.min(2)],
        _ => v.norm(),
    }
}
