//! Convex stand-ins: checked, simplified, shrunk, and made into engine shapes.

use super::convert::{vec3, vector};
use cullet_geometry::hull::{Hull, radius_of_ball, spiral};
use cullet_geometry::{Mat3, Vec3};
use rapier3d_f64::math::{Pose as EnginePose, Vector};
use rapier3d_f64::parry::query::details::intersection_test_support_map_support_map;
use rapier3d_f64::parry::shape::SupportMap;
use rapier3d_f64::parry::transformation::try_convex_hull;
use rapier3d_f64::prelude::SharedShape;
use std::panic::{AssertUnwindSafe, catch_unwind};

/// One convex part in the body frame.
#[derive(Clone)]
pub(super) struct Part {
    pub(super) shape: SharedShape,
    /// Middle of its corners \[m\].
    pub(super) centre: Vector,
    /// Greatest distance of a corner from the middle \[m\].
    pub(super) reach: f64,
    /// The corners that a ball was made of \[m\]; empty of what is none.
    on_ball: Vec<Vec3>,
}

impl Part {
    /// Its corners \[m\].
    pub(super) fn corners(&self) -> Vec<Vec3> {
        match self.shape.as_convex_polyhedron() {
            Some(hull) => hull.points().iter().map(|corner| vec3(*corner)).collect(),
            None => self.on_ball.clone(),
        }
    }
}

/// A convex hull by its corners; none of an empty one.
struct Corners<'a>(&'a [Vec3]);

impl SupportMap for Corners<'_> {
    fn local_support_point(&self, along: Vector) -> Vector {
        let along = vec3(along);
        let far = |one: &&Vec3, other: &&Vec3| one.dot(&along).total_cmp(&other.dot(&along));
        self.0.iter().max_by(far).map(vector).unwrap_or_default()
    }
}

/// Whether two convex hulls, of corners \[m\], lie in one another.
#[must_use]
pub fn hulls_overlap(one: &[Vec3], two: &[Vec3]) -> bool {
    let still = EnginePose::IDENTITY;
    !one.is_empty()
        && !two.is_empty()
        && intersection_test_support_map_support_map(&still, &Corners(one), &Corners(two))
}

/// Share by which a fragment's parts shrink towards their middle: 0.1 % already makes all contact
/// normals of touching cells right; the rest is room for rounding (F34).
const FRAGMENT_SHRINK: f64 = 3e-3;
/// The same for bodies of the scene, so that stacked boxes do not start at distance zero …
const BODY_SHRINK: f64 = 2e-4;
/// … but never by more than this, so that stacks do not sag and a large floor stays where it is
/// \[m\].
const BODY_SHRINK_MOST: f64 = 2e-5;
/// Corners of a tiny fragment's only hull; piles of such hulls settle (measured), richer ones
/// creep.
const TINY_CORNERS: usize = 14;
/// Corners of a fragment's hull: more only slows the contact search.
const FRAGMENT_CORNERS: usize = 32;
/// Corners of a hull of the scene: enough for a ball to roll.
const BODY_CORNERS: usize = 256;
/// A part whose corners spread less than this across its plane or line, over its reach, is drawn
/// out to it: contact needs some thickness \[1\].
const FLATTEST: f64 = 1e-6;
/// Below this spread over its reach a part's hull is made with exact predicates \[1\]: the engine
/// takes points for coplanar that spread by less than 3e-4 of the box around them.
const THIN: f64 = 2e-3;

/// How the corners of a part are treated.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Fit {
    /// A body of the scene.
    Body,
    /// A fragment.
    Fragment,
    /// A tiny fragment: one hull of few corners.
    Tiny,
}

/// What no part can be made of, if it is that.
pub(super) fn fault(corners: &[Vec3]) -> Option<&'static str> {
    if corners.len() < 4 {
        return Some("has fewer than 4 corners");
    }
    let finite = corners.iter().flatten().all(|x| x.is_finite());
    (!finite).then_some("has a corner that is not finite")
}

/// Makes the engine shape of one convex part, or says what is wrong with it. One without thickness
/// is given some.
pub(super) fn part(corners: &[Vec3], fit: Fit) -> Result<Part, &'static str> {
    if let Some(why) = fault(corners) {
        return Err(why);
    }
    if let Some(radius) = radius_of_ball(corners).filter(|_| fit == Fit::Body) {
        let share = 1.0 - BODY_SHRINK.min(BODY_SHRINK_MOST / radius);
        let (shape, reach) = (SharedShape::ball(share * radius), share * radius);
        let on_ball = extreme(corners, BODY_CORNERS).iter().map(|p| p * share).collect();
        return Ok(Part { shape, centre: Vector::ZERO, reach, on_ball });
    }
    let limit = match fit {
        Fit::Body => BODY_CORNERS,
        Fit::Fragment => FRAGMENT_CORNERS,
        Fit::Tiny => TINY_CORNERS,
    };
    let mut kept = extreme(corners, limit);
    let middle = kept.iter().sum::<Vec3>() / kept.len() as f64;
    let reach = kept.iter().map(|p| (p - middle).norm()).fold(0.0, f64::max);
    if reach == 0.0 {
        return Err("is a point");
    }
    let spread = Spread::of(&kept, &middle, reach);
    spread.draw_out(&mut kept);
    let share = match fit {
        Fit::Body => BODY_SHRINK.min(BODY_SHRINK_MOST / reach),
        Fit::Fragment | Fit::Tiny => FRAGMENT_SHRINK,
    };
    kept.iter_mut().for_each(|p| *p = middle + (*p - middle) * (1.0 - share));
    let shape = if spread.is_thin() { exact(&kept, limit) } else { quick(&kept) };
    let shape = shape.or_else(|| exact(&kept, limit)).ok_or("has no convex hull")?;
    Ok(Part { shape, centre: vector(&middle), reach, on_ball: Vec::new() })
}

/// The engine's own hull.
fn quick(corners: &[Vec3]) -> Option<SharedShape> {
    let points: Vec<Vector> = corners.iter().map(vector).collect();
    // The hull code has panicked on degenerate input before; a panic there is no hull here.
    let made = catch_unwind(AssertUnwindSafe(|| {
        try_convex_hull(&points).ok().and_then(|(v, t)| SharedShape::convex_mesh(v, &t))
    }));
    made.ok().flatten()
}

/// A hull with exact predicates.
fn exact(corners: &[Vec3], limit: usize) -> Option<SharedShape> {
    let hull = Hull::of(corners, limit)?;
    let points: Vec<Vector> = hull.vertices().iter().map(vector).collect();
    let faces: Vec<[u32; 3]> = hull.faces().iter().map(|f| f.map(|i| i as u32)).collect();
    let made = catch_unwind(AssertUnwindSafe(|| SharedShape::convex_mesh(points, &faces)));
    made.ok().flatten()
}

/// At most `limit` corners: all, or those farthest along evenly spread directions, in their given
/// order.
fn extreme(corners: &[Vec3], limit: usize) -> Vec<Vec3> {
    if corners.len() <= limit {
        return corners.to_vec();
    }
    let mut keep = vec![false; corners.len()];
    for k in 0..limit {
        let n = spiral(k, limit);
        let far = |best: usize, i: usize| {
            if n.dot(&corners[i]) > n.dot(&corners[best]) { i } else { best }
        };
        keep[(0..corners.len()).fold(0, far)] = true;
    }
    corners.iter().zip(keep).filter(|(_, keep)| *keep).map(|(p, _)| *p).collect()
}

/// How corners spread about their middle.
struct Spread {
    /// Principal axes, and the mean distance along each, root mean square, over the reach \[1\].
    axes: [(Vec3, f64); 3],
    reach: f64,
}

impl Spread {
    fn of(corners: &[Vec3], middle: &Vec3, reach: f64) -> Self {
        let sum = corners.iter().fold(Mat3::zeros(), |sum, p| {
            let r = (p - middle) / reach;
            sum + r * r.transpose()
        });
        let eigen = (sum / corners.len() as f64).symmetric_eigen();
        let axis = |i: usize| {
            let axis = eigen.eigenvectors.column(i).into_owned();
            (axis, eigen.eigenvalues[i].max(0.0).sqrt())
        };
        Self { axes: [axis(0), axis(1), axis(2)], reach }
    }

    fn is_thin(&self) -> bool {
        self.axes.iter().any(|(_, spread)| *spread < THIN)
    }

    /// Doubles the corners along each axis along which they hardly spread.
    fn draw_out(&self, corners: &mut Vec<Vec3>) {
        for (axis, _) in self.axes.iter().filter(|(_, spread)| *spread < FLATTEST) {
            let step = axis * (FLATTEST * self.reach);
            let there: Vec<Vec3> = corners.iter().map(|p| p + step).collect();
            corners.iter_mut().for_each(|p| *p -= step);
            corners.extend(there);
        }
    }
}

/// The corners of the box around a point set: what a part becomes when its own corners will not do.
pub(super) fn boxed(corners: impl Iterator<Item = Vec3> + Clone) -> Vec<Vec3> {
    let far = f64::INFINITY;
    let low = corners.clone().fold(Vec3::repeat(far), |a, p| a.inf(&p));
    let high = corners.fold(Vec3::repeat(-far), |a, p| a.sup(&p));
    (0..8u8)
        .map(|i| {
            let pick = |axis: usize| {
                if i >> axis & 1 == 1 { high[axis] } else { low[axis] }
            };
            Vec3::new(pick(0), pick(1), pick(2))
        })
        .collect()
}
