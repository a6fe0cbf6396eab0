//! Glue: rigid joints over the faces that bodies share.

use crate::body::Body;
use crate::id::BodyId;
use crate::joint::{JointError, JointId, JointLimit, JointLimits, JointLoad};
use crate::jointed::{JointLink, Jointed};
use crate::joints::{check_pair, known, put, within};
use crate::shared_face::{SharedFace, shared_face};
use crate::state::WorldState;
use cullet_geometry::{Pose, Vec3};
use std::collections::BTreeSet;

/// Which bodies are glued.
#[derive(Clone, Debug, PartialEq)]
pub enum GlueBodies {
    /// These pairs.
    Pairs(Vec<(BodyId, BodyId)>),
    /// All of these that touch each other.
    Group(Vec<BodyId>),
}

/// What glue bears.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum GlueLimit {
    /// The same for each pair, however large the face; `None`: any.
    EachPair {
        /// Size of the force without what presses the faces together \[N\].
        force: Option<f64>,
        /// Size of the torque about the middle of the face \[N·m\].
        torque: Option<f64>,
    },
    /// Stresses, linear over the face.
    Stress {
        /// Tension across it \[Pa\].
        tensile: f64,
        /// Shear along it \[Pa\].
        shear: f64,
    },
}

/// Glue to be put between bodies as they lie.
#[derive(Clone, Debug, PartialEq)]
pub struct GlueSpec {
    /// Between which.
    pub bodies: GlueBodies,
    /// What it bears.
    pub limit: GlueLimit,
    /// Faces that are no farther apart than this share an area; also how far they may lie in each
    /// other \[m\].
    pub gap: f64,
}

/// What was glued.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct GlueReport {
    /// The joints, in the order of their pairs.
    pub joints: Vec<JointId>,
    /// Area of all faces \[m²\].
    pub area: f64,
    /// Bodies that share a face with none of the others, in order.
    pub alone: Vec<BodyId>,
    /// Pairs that were named and share no face.
    pub apart: Vec<(BodyId, BodyId)>,
}

/// A face smaller than this share of the smaller body's reach, squared, is an edge \[1\].
const LEAST_FACE: f64 = 1e-6;
/// Greatest strength \[Pa\], force \[N\] and torque \[N·m\].
const STRONGEST: f64 = 1e30;

/// Most pairs of bodies that are looked at for a face that they share.
const MOST_PAIRS: usize = 4_000_000;
/// Most joints with those of glue.
const MOST_JOINTS: usize = 200_000;

/// [`crate::World::glue`].
pub(crate) fn glue(world: &mut WorldState, spec: &GlueSpec) -> Result<GlueReport, JointError> {
    let named = matches!(spec.bodies, GlueBodies::Pairs(_));
    let pairs = pairs(world, spec)?;
    let mut report = GlueReport::default();
    let mut made = Vec::new();
    let mut alone: BTreeSet<BodyId> = match &spec.bodies {
        GlueBodies::Pairs(pairs) => pairs.iter().flat_map(|&(a, b)| [a, b]).collect(),
        GlueBodies::Group(all) => all.iter().copied().collect(),
    };
    for &id in &alone {
        check(known(world, id)?.0, spec)?;
    }
    for (a, b) in pairs {
        let (one, at) = known(world, a)?;
        let (two, there) = known(world, b)?;
        if named {
            check_pair(one, Some(two))?;
        } else if one.immovable() && two.immovable() {
            continue;
        }
        let place = at.pose.inv_mul(&there.pose);
        match glued((a.0, one), (b.0, two), &place, spec.limit, spec.gap) {
            Some(joint) => {
                report.area += joint.face.area;
                alone.remove(&a);
                alone.remove(&b);
                made.push(joint);
            }
            None if named => report.apart.push((a, b)),
            None => {}
        }
    }
    if world.joints.all.len() + made.len() > MOST_JOINTS {
        return Err(JointError::TooMany { what: "joints in the world", most: MOST_JOINTS });
    }
    report.alone = alone.into_iter().collect();
    report.joints = made.into_iter().map(|joint| JointId(put(world, joint))).collect();
    Ok(report)
}

/// The glue between two bodies, if they share a face; `place` leads from the frame of the second to
/// that of the first.
pub(crate) fn glued(
    (a, one): (u32, &Body),
    (b, two): (u32, &Body),
    place: &Pose,
    limit: GlueLimit,
    gap: f64,
) -> Option<Jointed> {
    let apart = place.translation.vector.norm();
    if apart > one.reach + two.reach + gap {
        return None;
    }
    let SharedFace { middle, face } = shared_face(&one.solid.mesh, &two.solid.mesh, place, gap)?;
    let reach = one.reach.min(two.reach);
    if face.area < LEAST_FACE * reach * reach {
        return None;
    }
    let end = place.inverse_transform_point(&nalgebra::Point3::from(middle)).coords;
    Some(Jointed {
        a,
        b: Some(b),
        link: JointLink::Rigid,
        ends: [middle, end],
        turn: place.rotation.inverse(),
        face,
        limit: match limit {
            GlueLimit::EachPair { force, torque } => {
                JointLimit::Pull(JointLimits { force, torque })
            }
            GlueLimit::Stress { tensile, shear } => JointLimit::Stress { tensile, shear },
        },
        gap,
        collide: false,
        load: JointLoad::zero(),
    })
}

fn check(body: &Body, spec: &GlueSpec) -> Result<(), JointError> {
    let least = f64::MIN_POSITIVE;
    within(body, "gap of the glue [m]", spec.gap, least, 1e3)?;
    let rows = match spec.limit {
        GlueLimit::EachPair { force, torque } => {
            [("force of the glue [N]", force), ("torque of the glue [N·m]", torque)]
        }
        GlueLimit::Stress { tensile, shear } => [
            ("tensile strength of the glue [Pa]", Some(tensile)),
            ("shear strength of the glue [Pa]", Some(shear)),
        ],
    };
    let set = rows.into_iter().filter_map(|(what, value)| Some((what, value?)));
    set.into_iter().try_for_each(|(what, value)| within(body, what, value, least, STRONGEST))
}

/// The axis along which bodies lie farthest apart.
fn widest(spans: &[(Vec3, f64, BodyId)]) -> usize {
    let none = (Vec3::repeat(f64::INFINITY), Vec3::repeat(f64::NEG_INFINITY));
    let add = |(low, high): (Vec3, Vec3), (middle, ..): &(Vec3, f64, BodyId)| {
        (low.inf(middle), high.sup(middle))
    };
    let (low, high) = spans.iter().fold(none, add);
    (high - low).imax()
}

/// The pairs that may be glued, the lower body first, in order, each once; of a group those whose
/// balls meet along the axis along which it is longest.
fn pairs(world: &WorldState, spec: &GlueSpec) -> Result<Vec<(BodyId, BodyId)>, JointError> {
    let mut pairs = BTreeSet::new();
    match &spec.bodies {
        GlueBodies::Pairs(named) => {
            for &(a, b) in named {
                if a == b {
                    let name = known(world, a)?.0.name.clone();
                    return Err(JointError::Itself { name });
                }
                pairs.insert((a.min(b), a.max(b)));
            }
        }
        GlueBodies::Group(all) => {
            let all: BTreeSet<BodyId> = all.iter().copied().collect();
            let mut spans = Vec::with_capacity(all.len());
            for id in all {
                let (body, motion) = known(world, id)?;
                spans.push((motion.centre(), body.reach + spec.gap, id));
            }
            let axis = widest(&spans);
            let span = |(middle, half, id): (Vec3, f64, BodyId)| {
                (middle[axis] - half, middle[axis] + half, id)
            };
            let mut spans: Vec<(f64, f64, BodyId)> = spans.into_iter().map(span).collect();
            spans.sort_by(|one, two| one.0.total_cmp(&two.0).then(one.2.cmp(&two.2)));
            for (k, &(_, end, a)) in spans.iter().enumerate() {
                let near = spans[k + 1..].iter().take_while(|(start, ..)| *start <= end);
                pairs.extend(near.map(|&(.., b)| (a.min(b), a.max(b))));
                if pairs.len() > MOST_PAIRS {
                    return Err(JointError::TooMany {
                        what: "pairs near each other",
                        most: MOST_PAIRS,
                    });
                }
            }
        }
    }
    Ok(pairs.into_iter().collect())
}
