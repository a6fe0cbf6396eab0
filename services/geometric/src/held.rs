//! What holds a body while it breaks: a support stops the pieces that lie on it and throws none
//! back. It gives no more than they push into it; the others go on without it.

use cullet_geometry::inside::closest_on_triangle;
use cullet_model::{Fragment, Support};

/// A face whose outward normal turns further away than this from the direction in which a support
/// yields does not lie on it: the cosine of that angle \[1\].
const FACING: f64 = 0.5;

/// Passes over all contacts: a piece in a corner is stopped by both of its sides.
const PASSES: u32 = 8;

/// Supports whose normals differ by less than this share the stopping of a piece: the cosine of
/// that angle \[1\].
const TOGETHER: f64 = 0.9;

/// A support and a piece that lies on it, by their places; `share`: of the stopping of that piece
/// \[1\].
struct SupportContact {
    support: usize,
    piece: usize,
    share: f64,
}

/// Stops the pieces that move into what they lie on, and returns what each support gave along its
/// normal \[N·s\].
///
/// The impact of pieces and support is perfectly inelastic: both end with one speed along the
/// normal, which is zero where the support does not move.
pub(super) fn stop(fragments: &mut [Fragment], supports: &[Support], density: f64) -> Vec<f64> {
    let masses: Vec<f64> =
        fragments.iter().map(|f| f.solid.mesh.signed_volume() * density).collect();
    let contacts = contacts(fragments, supports);
    let mut given = vec![0.0; supports.len()];
    for _ in 0..PASSES {
        let speed = |contact: &SupportContact| {
            let support = &supports[contact.support];
            let own = support.mobility * given[contact.support];
            (-fragments[contact.piece].velocity.dot(&support.normal) - own).max(0.0)
        };
        let speeds: Vec<f64> = contacts.iter().map(speed).collect();
        let mut carried = vec![0.0; supports.len()];
        for (contact, _) in contacts.iter().zip(&speeds).filter(|(_, speed)| **speed > 0.0) {
            carried[contact.support] += masses[contact.piece] * contact.share;
        }
        for (SupportContact { support, piece, share }, speed) in contacts.iter().zip(speeds) {
            let Support { normal, mobility, .. } = supports[*support];
            let change = share * speed / (1.0 + mobility * carried[*support]);
            fragments[*piece].velocity += normal * change;
            given[*support] += masses[*piece] * change;
        }
    }
    given
}

fn contacts(fragments: &[Fragment], supports: &[Support]) -> Vec<SupportContact> {
    let mut contacts = Vec::new();
    for (piece, fragment) in fragments.iter().enumerate() {
        let on: Vec<usize> =
            (0..supports.len()).filter(|&s| lies_on(fragment, &supports[s])).collect();
        for &support in &on {
            let normal = supports[support].normal;
            let like = |&&other: &&usize| supports[other].normal.dot(&normal) > TOGETHER;
            let share = 1.0 / on.iter().filter(like).count() as f64;
            contacts.push(SupportContact { support, piece, share });
        }
    }
    contacts
}

/// Has the fragment a face within the disc of the support?
fn lies_on(fragment: &Fragment, support: &Support) -> bool {
    let mesh = &fragment.solid.mesh;
    (0..mesh.triangles.len()).any(|t| {
        let corners = mesh.corners(t);
        let out = (corners[1] - corners[0]).cross(&(corners[2] - corners[0]));
        let nearest = closest_on_triangle(support.point, corners);
        -out.dot(&support.normal) > FACING * out.norm()
            && (nearest - support.point).norm() <= support.radius
    })
}
