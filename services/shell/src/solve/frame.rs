//! Problems into the frame of the solve, and what comes of them back.

use crate::midsurface::placed;
use cullet_geometry::{Pose, Solid, Vec3};
use cullet_model::strength::Region;
use cullet_model::{BrittleProblem, Fragmentation, StrengthField};
use std::sync::Arc;

fn moved(solid: &mut Solid, pose: &Pose) {
    solid.mesh.vertices.iter_mut().for_each(|x| *x = placed(pose, x));
}

/// The problem in the frame that `pose` leads from, to the body's.
pub(super) fn to_local(problem: &BrittleProblem, pose: &Pose) -> BrittleProblem {
    let pose = pose.inverse();
    let mut local = problem.clone();
    let mut solid = Solid::clone(&problem.solid);
    moved(&mut solid, &pose);
    local.solid = Arc::new(solid);
    for hit in &mut local.impacts {
        (hit.point, hit.normal) = (placed(&pose, &hit.point), pose.rotation * hit.normal);
    }
    for support in &mut local.supports {
        support.point = placed(&pose, &support.point);
        support.normal = pose.rotation * support.normal;
    }
    local
}

/// The grooves of scored lines, as cells of `spacing` \[m\] have them, in the plate's frame.
pub(super) fn scored(strength: &StrengthField, spacing: f64, pose: &Pose) -> Vec<Region> {
    let pose = pose.inverse();
    let mut grooves = strength.scored(spacing);
    for groove in &mut grooves {
        if let Region::Groove { from, to, inward, .. } = groove {
            (*from, *to) = (placed(&pose, from), placed(&pose, to));
            *inward = pose.rotation * *inward;
        }
    }
    grooves
}

/// The plate's solid in the body's frame.
pub(super) fn of_body(solid: &Solid, pose: &Pose) -> Solid {
    let mut solid = solid.clone();
    moved(&mut solid, pose);
    solid
}

/// What came of it in the body's frame.
pub(super) fn from_local(mut fracture: Fragmentation, pose: &Pose) -> Fragmentation {
    let turn = |x: &mut Vec3| *x = pose.rotation * *x;
    for fragment in &mut fracture.fragments {
        moved(&mut fragment.solid, pose);
        fragment.sheet.mesh.vertices.iter_mut().for_each(|x| *x = placed(pose, x));
        fragment.hulls.iter_mut().flatten().for_each(|x| *x = placed(pose, x));
        turn(&mut fragment.velocity);
        turn(&mut fragment.spin);
    }
    for grain in &mut fracture.debris {
        grain.position = placed(pose, &grain.position);
        turn(&mut grain.velocity);
    }
    fracture
}
