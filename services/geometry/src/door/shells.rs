//! Closed shells and how they lie in each other.

use super::{DoorError, RepairReport};
use crate::inside::Inside;
use crate::mesh::TriMesh;

/// A shell whose volume is under this share of its box's cube is flat.
const FLAT: f64 = 1e-9;
/// Vertices of a shell that are tested for lying in another.
const SAMPLES: usize = 64;
/// Shells beyond which nesting is not looked at: the search is quadratic.
const MAX_SHELLS: usize = 2_000;

/// What becomes of a shell.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum ShellFate {
    Keep,
    Flip,
    Drop,
}

/// Refuses a closed mesh with a shell that is flat, inside out, or inside another without being its
/// cavity.
pub(super) fn check(mesh: &TriMesh) -> Result<(), DoorError> {
    let shells = shells(mesh);
    let fates = fates(&shells);
    match fates.iter().position(|f| *f != ShellFate::Keep) {
        None => Ok(()),
        Some(shell) => {
            let volume = shells[shell].signed_volume();
            Err(DoorError::Inverted { shell, shells: shells.len(), volume })
        }
    }
}

/// Least volume of a shell that is as large as the mesh \[m³\].
pub(super) fn least_volume(mesh: &TriMesh) -> f64 {
    let diagonal = mesh.diagonal();
    FLAT * diagonal * diagonal * diagonal
}

/// The mesh with outer shells facing outward and cavities inward, without flat or swallowed shells.
pub(super) fn ordered(mesh: &TriMesh, report: &mut RepairReport) -> TriMesh {
    let shells = shells(mesh);
    let fates = fates(&shells);
    if fates.iter().all(|f| *f == ShellFate::Keep) {
        return mesh.clone();
    }
    let mut out = TriMesh::default();
    for (shell, fate) in shells.iter().zip(fates) {
        match fate {
            ShellFate::Keep => out.append(shell),
            ShellFate::Flip => {
                report.flipped += shell.triangles.len();
                out.append(&shell.flipped());
            }
            ShellFate::Drop => report.dropped_shells += 1,
        }
    }
    out
}

/// Parts that face outward, each with the cavities that lie in it and in no smaller one.
pub(super) fn with_cavities(parts: Vec<TriMesh>) -> Vec<TriMesh> {
    let outward = |part: &TriMesh| part.signed_volume() > 0.0;
    let (mut bodies, cavities): (Vec<_>, Vec<_>) = parts.into_iter().partition(outward);
    bodies.sort_by(|a, b| a.signed_volume().total_cmp(&b.signed_volume()));
    let insides: Vec<Inside> = match cavities.is_empty() {
        true => Vec::new(),
        false => bodies.iter().map(Inside::new).collect(),
    };
    for cavity in cavities {
        let around = insides.iter().position(|inside| share_in(&cavity, inside) >= 0.5);
        around.into_iter().for_each(|k| bodies[k].append(&cavity));
    }
    bodies
}

fn shells(mesh: &TriMesh) -> Vec<TriMesh> {
    mesh.components().iter().map(|c| mesh.submesh(c)).collect()
}

/// Decides from the largest shell to the smallest. A shell in empty space is made to face outward;
/// one in material is its cavity if it faces inward, and swallowed by it if it faces outward. Only
/// what lies wholly in another shell is swallowed by it; those that cross are left to the rebuild.
/// A cavity may touch the shell around it: most of it lies inside.
fn fates(shells: &[TriMesh]) -> Vec<ShellFate> {
    let volumes: Vec<f64> = shells.iter().map(TriMesh::signed_volume).collect();
    let mut order: Vec<usize> = (0..shells.len()).collect();
    order.sort_by(|&a, &b| volumes[b].abs().total_cmp(&volumes[a].abs()).then(a.cmp(&b)));
    let mut fates = vec![ShellFate::Keep; shells.len()];
    let mut placed: Vec<(Inside, i32)> = Vec::new();
    for &s in &order {
        if volumes[s].abs() <= least_volume(&shells[s]) {
            fates[s] = ShellFate::Drop;
            continue;
        }
        let outward = volumes[s] > 0.0;
        let least = if outward { 1.0 } else { 0.5 };
        let around = placed.iter().filter(|(inside, _)| share_in(&shells[s], inside) >= least);
        let winding: i32 = around.map(|(_, sign)| sign).sum();
        let sign = match (winding > 0, outward) {
            (true, true) => {
                fates[s] = ShellFate::Drop;
                continue;
            }
            (true, false) => -1,
            (false, true) => 1,
            (false, false) => {
                fates[s] = ShellFate::Flip;
                1
            }
        };
        if shells.len() > 1 && shells.len() <= MAX_SHELLS {
            placed.push((Inside::new(&shells[s]), sign));
        }
    }
    fates
}

/// The share of a shell's vertices, or of a sample of them, that lie inside another.
fn share_in(shell: &TriMesh, inside: &Inside) -> f64 {
    let step = shell.vertices.len().div_ceil(SAMPLES).max(1);
    let samples: Vec<_> = shell.vertices.iter().step_by(step).collect();
    let within = samples.iter().filter(|&&&p| inside.contains(p)).count();
    within as f64 / samples.len() as f64
}
