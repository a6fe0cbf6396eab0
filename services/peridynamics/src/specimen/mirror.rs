//! Planes that the body is held or mirrored on: what lies behind them goes as the body's image.
//!
//! Bonds reach through a side of the body, so that a row of points which is held does not hold
//! what lies beside it. Behind such a side is the body's image instead, two horizons deep.
//!
//! - A plane of symmetry, or one that moves at v along its normal and is free across: the image of
//!   a point that moves at u moves at 2v − u along the normal, and with it across. So the strain
//!   goes on through the plane, whose points move at v, and forces are those of twice the body.
//! - A plane that is held across too: no image of what moves gives forces that have a potential.
//!   All that is behind it moves at v along the axes that are held: it is a grip.

use crate::Peridynamics;
use crate::domain::PeridynamicDomain;
use cullet_geometry::Vec3;
use cullet_model::strength::Region;
use cullet_model::{Refusal, Solver};
use cullet_specimen::{Drive, GridFrame, Hold, SpecimenProblem, within};

/// How far a plane of a support may be from a side of the body \[spacings\].
const ON_PLANE: f64 = 1e-3;

/// Scattered points are kept this far from a plane, so that none meets its image \[spacings\].
const CLEAR: f64 = 0.25;

/// A side of the body that is held, or on which it is mirrored.
#[derive(Clone, Debug, PartialEq)]
struct FacePlane {
    axis: usize,
    /// Where along it \[m\].
    at: f64,
    /// Supports that lie on it.
    holds: Vec<usize>,
    /// Whether it is a plane of symmetry.
    is_symmetry: bool,
    /// 1 where the body lies above it along the axis, else -1.
    side: f64,
}

/// The image of a point.
#[derive(Clone, Copy, Debug, PartialEq)]
struct PointImage {
    /// Of which point: one of the body, or an image before this one.
    source: usize,
    plane: usize,
    /// Where between both it crosses the plane, in the specimen's frame \[m\].
    foot: Vec3,
}

/// Planes and images.
#[derive(Clone, Debug, Default)]
pub(super) struct MirrorSet {
    planes: Vec<FacePlane>,
    images: Vec<PointImage>,
    supports: Vec<Hold>,
}

/// What the images did to a body in a step.
#[derive(Clone, Debug, Default)]
pub(super) struct ImageStep {
    /// Work of the supports \[J\].
    pub(super) work: f64,
    /// Force of each on the body, in the specimen's frame \[N\].
    pub(super) reactions: Vec<Vec3>,
}

/// A refusal for what the body or the law lacks.
pub(super) fn unfit(lack: String) -> Refusal {
    Refusal::Unfit { solver: Peridynamics::NAME, lack }
}

impl MirrorSet {
    /// The planes of a specimen.
    pub(super) fn new(specimen: &SpecimenProblem) -> Self {
        let (low, high) = specimen.body.mesh.bounds().unwrap_or_default();
        let slack = ON_PLANE * specimen.settings.spacing;
        let mut all = Self { supports: specimen.holds.clone(), ..Self::default() };
        for mirror in &specimen.symmetries {
            let axis = usize::from(mirror.axis.min(2));
            let middle = 0.5 * (low + high)[axis];
            all.plane(axis, mirror.at, if middle >= mirror.at { 1.0 } else { -1.0 }, slack);
            all.planes.iter_mut().for_each(|plane| plane.is_symmetry = true);
        }
        for (index, hold) in specimen.holds.iter().enumerate() {
            for region in &hold.part {
                let Region::HalfSpace { point, normal } = region else { continue };
                let axis = normal.iamax();
                let side = normal[axis].signum();
                let at = if side > 0.0 { low[axis] } else { high[axis] };
                let is_along = normal[axis].abs() > 1.0 - 1e-12;
                let is_on = is_along && (point[axis] - at).abs() <= slack;
                if is_on && hold.axes[axis] && hold.until.is_none() {
                    let plane = all.plane(axis, at, side, slack);
                    all.planes[plane].holds.push(index);
                }
            }
        }
        all
    }

    /// The number of a plane, which is new where there was none.
    fn plane(&mut self, axis: usize, at: f64, side: f64, slack: f64) -> usize {
        let same = |plane: &FacePlane| plane.axis == axis && (plane.at - at).abs() <= slack;
        self.planes.iter().position(same).unwrap_or_else(|| {
            let (holds, is_symmetry) = (Vec::new(), false);
            self.planes.push(FacePlane { axis, at, holds, is_symmetry, side });
            self.planes.len() - 1
        })
    }

    /// How many images there are.
    pub(super) fn len(&self) -> usize {
        self.images.len()
    }

    /// Whether a support lies on a plane.
    pub(super) fn has_support(&self, index: usize) -> bool {
        self.images.iter().any(|image| self.planes[image.plane].holds.contains(&index))
    }

    /// Where rows lie against the grid: a plane is half a spacing from two of them.
    pub(super) fn row_offset(&self, specimen: &SpecimenProblem, frame: &GridFrame) -> Vec3 {
        let mut offset = Vec3::repeat(0.5);
        for plane in self.planes.iter().filter(|_| frame.is_straight()).rev() {
            let at = (plane.at + specimen.body.shift[plane.axis]) / specimen.settings.spacing;
            let at = at + 0.5;
            offset[plane.axis] = at - at.floor();
        }
        offset
    }

    /// Adds to the places of the body, in the specimen's frame, the images of those that lie within
    /// `depth` \[m\] of a plane.
    ///
    /// # Errors
    /// The body lies on both sides of a plane.
    pub(super) fn images(
        &mut self,
        specimen: &SpecimenProblem,
        depth: f64,
        places: &mut Vec<Vec3>,
    ) -> Result<(), Refusal> {
        let (h, own) = (specimen.settings.spacing, places.len());
        for (number, plane) in self.planes.iter().enumerate() {
            let axis = plane.axis;
            let off = |x: &Vec3| (x[axis] - plane.at) * plane.side;
            if places[..own].iter().any(|x| off(x) < -0.5 * h) {
                return Err(unfit(format!(
                    "the body lies on both sides of the plane at {:.3e} m on which it is held or \
                     mirrored",
                    plane.at
                )));
            }
            for x in places[..own].iter_mut().filter(|x| off(x) < CLEAR * h) {
                x[axis] = plane.at + CLEAR * h * plane.side;
            }
            for source in 0..places.len() {
                let mut place = places[source];
                let mut foot = place;
                foot[axis] = plane.at;
                let slack = ON_PLANE * h;
                let is_held = || {
                    let parts = plane.holds.iter().map(|&k| &specimen.holds[k].part);
                    parts.into_iter().any(|part| within(part, &foot, slack))
                };
                if off(&place) <= depth && (plane.is_symmetry || is_held()) {
                    place[axis] = 2.0 * plane.at - place[axis];
                    places.push(place);
                    self.images.push(PointImage { source, plane: number, foot });
                }
            }
        }
        Ok(())
    }

    /// The place of the body that a place in the specimen is the image of, or itself.
    pub(super) fn unfolded(&self, x: &Vec3) -> Vec3 {
        let mut x = *x;
        for plane in &self.planes {
            if (x[plane.axis] - plane.at) * plane.side < 0.0 {
                x[plane.axis] = 2.0 * plane.at - x[plane.axis];
            }
        }
        x
    }

    /// Images of a grip: bonds that reach into it store energy at both of their ends.
    pub(super) fn gripped(&self) -> impl Iterator<Item = usize> {
        let grips = |image: &PointImage| self.is_grip(&self.planes[image.plane]);
        let images = self.images.iter().enumerate();
        images.filter(move |(_, image)| grips(image)).map(|(k, _)| k)
    }

    /// Whether a plane is held across its normal, too.
    fn is_grip(&self, plane: &FacePlane) -> bool {
        let across = |k: &usize| (0..3).any(|a| a != plane.axis && self.supports[*k].axes[a]);
        plane.holds.iter().any(across)
    }

    /// Gives the images their velocities in a step with the forces of now, by those of the body.
    pub(super) fn apply(
        &self,
        domain: &PeridynamicDomain,
        frame: &GridFrame,
        drive: &Drive<'_>,
        velocities: &mut [Vec3],
    ) -> ImageStep {
        let mut reactions = vec![Vec3::zeros(); self.supports.len()];
        let mut work = 0.0;
        for (k, image) in self.images.iter().enumerate() {
            let (p, plane) = (domain.own + k, &self.planes[image.plane]);
            let mut own = frame.unturned(&velocities[image.source]);
            let force = frame.unturned(&domain.forces[p]);
            for axis in 0..3 {
                let is_symmetry = plane.is_symmetry && axis == plane.axis;
                let held = plane.holds.iter().filter_map(|&k| Some((k, drive.holds[k]?)));
                let held = held.filter(|(k, _)| {
                    let hold = &self.supports[*k];
                    let slack = ON_PLANE * libm::cbrt(domain.volumes[p]);
                    hold.axes[axis] && within(&hold.part, &image.foot, slack)
                });
                let (mut speed, mut first) = (0.0, None);
                for (k, factor) in held {
                    let hold = &self.supports[k];
                    let slope = hold.gradient * (image.foot - hold.centre);
                    speed += factor * (hold.velocity + slope)[axis];
                    first = first.or(Some(k));
                }
                if is_symmetry || first.is_some() {
                    let is_grip = !is_symmetry && self.is_grip(plane);
                    own[axis] = if is_grip { speed } else { 2.0 * speed - own[axis] };
                }
                if let Some(k) = first {
                    reactions[k][axis] -= force[axis];
                    work -= force[axis] * speed * drive.step;
                }
            }
            velocities[p] = frame.turned(&own);
        }
        ImageStep { work, reactions }
    }
}
