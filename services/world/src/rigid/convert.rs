//! The house's algebra to the engine's and back, bit for bit.

use cullet_geometry::{Mat3, Pose, Quat, Vec3};
use nalgebra::{Quaternion, Translation3};
use rapier3d_f64::math::{Pose as EnginePose, Rotation, Vector};
use rapier3d_f64::prelude::MassProperties;

pub(super) fn vector(v: &Vec3) -> Vector {
    Vector::new(v.x, v.y, v.z)
}

pub(super) fn vec3(v: Vector) -> Vec3 {
    Vec3::new(v.x, v.y, v.z)
}

pub(super) fn rotation(q: &Quat) -> Rotation {
    Rotation::from_xyzw(q.i, q.j, q.k, q.w)
}

pub(super) fn engine_pose(pose: &Pose) -> EnginePose {
    EnginePose::from_parts(vector(&pose.translation.vector), rotation(&pose.rotation))
}

pub(super) fn pose(p: &EnginePose) -> Pose {
    let q = p.rotation;
    Pose::from_parts(
        Translation3::from(vec3(p.translation)),
        Quat::new_unchecked(Quaternion::new(q.w, q.x, q.y, q.z)),
    )
}

/// The engine's own closed-form eigenvalues are good to half the digits only; these are good to
/// all.
pub(super) fn mass_properties(mass: f64, inertia: &Mat3) -> MassProperties {
    let eigen = inertia.symmetric_eigen();
    let mut axes = eigen.eigenvectors;
    if axes.determinant() < 0.0 {
        axes.column_mut(2).neg_mut();
    }
    let turn = Quat::from_rotation_matrix(&nalgebra::Rotation3::from_matrix_unchecked(axes));
    MassProperties::with_principal_inertia_frame(
        Vector::ZERO,
        mass,
        vector(&eigen.eigenvalues),
        rotation(&turn),
    )
}
