//! Reading probes off a body.

use crate::books::EnergyBooks;
use crate::discretisation::{BodySums, Discretisation, FieldValues, PointFields};
use crate::frame::GridFrame;
use crate::place::{Where, within};
use crate::probe::{PointField, Probe, Reduce, Spot, TensorPart};
use cullet_geometry::symmetric::{Sym3, eigen};
use cullet_geometry::{Mat3, Vec3};

/// Pitch of the squares that count the area of a crack, in spacings.
const SQUARE: f64 = 1.0;

/// What is read off a body at one time.
pub(crate) struct ProbeReader<'a> {
    pub(crate) body: &'a dyn Discretisation,
    pub(crate) frame: &'a GridFrame,
    pub(crate) books: &'a EnergyBooks,
    /// There where a probe needs them.
    pub(crate) sums: Option<BodySums>,
    /// Spacing \[m\].
    pub(crate) spacing: f64,
    pub(crate) points: PointFields,
    /// Where the points are in the specimen.
    pub(crate) places: Vec<Vec3>,
}

impl ProbeReader<'_> {
    pub(crate) fn value(&self, probe: &Probe) -> f64 {
        match probe {
            Probe::Points(field, part, spot) => self.points(*field, *part, spot),
            Probe::Reaction(hold, part) => {
                vector_part(&self.books.reactions[*hold as usize], *part)
            }
            Probe::Applied(load, part) => vector_part(&self.books.applied[*load as usize], *part),
            Probe::Kinetic => self.sum(|sums| sums.kinetic),
            Probe::Elastic => self.sum(|sums| sums.elastic),
            Probe::Dissipated => self.books.dissipated,
            Probe::Damped => self.books.damped,
            Probe::Met => self.books.met,
            Probe::Work => self.books.work,
            Probe::Balance => self.sum(|sums| self.books.balance(sums)),
            Probe::Momentum(part) => {
                self.sum(|sums| vector_part(&self.frame.unturned(&sums.momentum), *part))
            }
            Probe::AngularMomentum(part) => self.sum(|sums| {
                let origin = self.frame.onto(&Vec3::zeros());
                let about = sums.angular_momentum - origin.cross(&sums.momentum);
                vector_part(&self.frame.unturned(&about), *part)
            }),
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
                self.body.pieces().iter().filter(|&&piece| piece >= *share).count() as f64
            }
            Probe::Largest => self.body.pieces().first().copied().unwrap_or(0.0),
        }
    }

    fn sum(&self, number: impl FnOnce(&BodySums) -> f64) -> f64 {
        self.sums.as_ref().map_or(f64::NAN, number)
    }

    /// One number of one point; `ahead` is how far from it to look \[m\].
    pub(crate) fn at(&self, p: usize, field: PointField, part: TensorPart, ahead: &Vec3) -> f64 {
        match self.points.fields.get(&field) {
            Some(FieldValues::Numbers(all)) => all[p],
            Some(FieldValues::Vectors(all)) => {
                let v = all[p].value + all[p].gradient * self.frame.turned(ahead);
                vector_part(&self.frame.unturned(&v), part)
            }
            Some(FieldValues::Tensors(all)) => self.tensor_part(&all[p], part),
            None => f64::NAN,
        }
    }

    fn points(&self, field: PointField, part: TensorPart, spot: &Spot) -> f64 {
        match spot {
            Spot::At(x) => {
                let far = |p: usize| (self.places[p] - x).norm_squared();
                let numbers = &self.points.numbers;
                let nearest = (0..self.places.len())
                    .min_by(|&a, &b| far(a).total_cmp(&far(b)).then(numbers[a].cmp(&numbers[b])));
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
                        let volume = &self.points.volumes;
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

    fn tensor_part(&self, s: &Sym3, part: TensorPart) -> f64 {
        let trace = s[0] + s[1] + s[2];
        let square = |s: &Sym3| {
            let shear = s[3] * s[3] + s[4] * s[4] + s[5] * s[5];
            s[0] * s[0] + s[1] * s[1] + s[2] * s[2] + 2.0 * shear
        };
        match part {
            TensorPart::Mean => trace / 3.0,
            TensorPart::Size => square(s).sqrt(),
            TensorPart::Mises => (1.5 * (square(s) - trace * trace / 3.0).max(0.0)).sqrt(),
            TensorPart::Greatest => eigen(s).0.into_iter().fold(f64::NEG_INFINITY, f64::max),
            TensorPart::Least => eigen(s).0.into_iter().fold(f64::INFINITY, f64::min),
            TensorPart::Pair(k) | TensorPart::Axis(k) => {
                let m = Mat3::new(s[0], s[3], s[5], s[3], s[1], s[4], s[5], s[4], s[2]);
                let pairs = [(0, 0), (1, 1), (2, 2), (0, 1), (1, 2), (2, 0)];
                let (i, j) = pairs[usize::from(k).min(5)];
                let axis = |a: usize| self.frame.turned(&Vec3::ith(a, 1.0));
                axis(i).dot(&(m * axis(j)))
            }
        }
    }

    fn damage(&self) -> &[f64] {
        match self.points.fields.get(&PointField::Damage) {
            Some(FieldValues::Numbers(all)) => all,
            _ => &[],
        }
    }

    fn broken<'b>(&'b self, part: &'b Where) -> impl Iterator<Item = usize> + 'b {
        let damage = self.damage();
        (0..damage.len()).filter(move |&p| damage[p] >= 1.0 && within(part, &self.places[p], 0.0))
    }

    fn damaged(&self, part: &Where, bound: f64) -> f64 {
        let damage = self.damage();
        let taken =
            (0..damage.len()).filter(|&p| damage[p] > bound && within(part, &self.places[p], 0.0));
        taken.map(|p| self.points.volumes[p]).sum()
    }

    fn crack_area(&self, part: &Where, normal: &Vec3) -> f64 {
        let pitch = SQUARE * self.spacing;
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
}

/// The greatest; no number if one of them is none, or there are none.
fn most(values: impl Iterator<Item = f64>) -> f64 {
    let greater = |m: f64, v: f64| if m.is_nan() || v <= m { m } else { v };
    values.reduce(greater).unwrap_or(f64::NAN)
}

fn vector_part(v: &Vec3, part: TensorPart) -> f64 {
    match part {
        TensorPart::Axis(k) => v[usize::from(k).min(2)],
        _ => v.norm(),
    }
}
