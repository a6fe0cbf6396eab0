//! What crack faces know at their corners.

use super::{Cloud, NO_DETAIL, SETTINGS, by_sites, cube, extract};
use crate::cut::{CutPart, CutSettings};
use cullet_geometry::math::unit;
use cullet_geometry::{Surface, Vec3};
use cullet_model::CrackFaceDetail;

/// Place, time and speed at each corner of a part's crack faces.
fn corners(part: &CutPart) -> Vec<(Vec3, [f32; 2])> {
    let mut all = Vec::new();
    for (t, surface) in part.solid.surface.iter().enumerate() {
        if let Surface::Crack { damage_time, front_speed, .. } = *surface {
            let marks = [0, 1, 2].map(|k| [damage_time[k], front_speed[k]]);
            all.extend(part.solid.mesh.corners(t).into_iter().zip(marks));
        }
    }
    all
}

/// Two bands that cross, the front running along a third direction and slowing down.
fn quarters(detail: CrackFaceDetail) -> Vec<CutPart> {
    let h = 0.08;
    let band = |x: f64| (x - 0.5).abs() < 0.8 * h;
    let mut cloud = Cloud::in_cube(h, |p| band(p.y) || band(p.x + 0.1 * p.z));
    for (time, p) in cloud.time.iter_mut().zip(&cloud.positions) {
        if time.is_finite() {
            *time = (p.z + 0.3 * p.x + 0.4 * p.z * p.z) / 800.0;
        }
    }
    let settings = CutSettings { detail, ..SETTINGS };
    extract(&cube(), &cloud.field(), &settings).unwrap().parts
}

#[test]
fn both_sides_of_a_crack_have_equal_values_at_equal_places() {
    let rough = CrackFaceDetail { height: 0.3, grain: 0.1, ..CrackFaceDetail::NONE };
    for detail in [NO_DETAIL, rough] {
        let parts = quarters(detail);
        assert_eq!(parts.len(), 4);
        let mut shared = 0;
        for (k, part) in parts.iter().enumerate() {
            let mine = corners(part);
            for other in &parts[k + 1..] {
                for (q, theirs) in corners(other) {
                    let same = mine.iter().filter(|(p, _)| (p - q).norm() < 1e-12);
                    for (_, own) in same {
                        let error = |k: usize| (own[k] / theirs[k] - 1.0).abs();
                        assert!(error(0) < 1e-6 && error(1) < 1e-6, "{own:?} {theirs:?} at {q:?}");
                        shared += 1;
                    }
                }
            }
        }
        assert!(shared > 2000, "{shared} corners in common");
    }
}

#[test]
fn values_are_smooth_along_a_face_and_not_one_a_face() {
    for part in quarters(NO_DETAIL) {
        let all = corners(&part);
        // One value at one place, whatever face asks; and within a face they differ.
        let mut sorted: Vec<_> = all.iter().map(|(p, m)| ([p.x, p.y, p.z], m)).collect();
        sorted.sort_by(|a, b| a.partial_cmp(b).unwrap());
        let mean = |p: &[f64; 3]| (p[2] + 0.3 * p[0] + 0.4 * p[2] * p[2]) / 800.0;
        for pair in sorted.windows(2).filter(|pair| pair[0].0 == pair[1].0) {
            assert!((pair[0].1[0] / pair[1].1[0] - 1.0).abs() < 1e-6);
        }
        let errors = sorted.iter().map(|(p, m)| f64::from(m[0]) - mean(p));
        let worst = errors.fold(0.0_f64, |worst, error| worst.max(error.abs()));
        assert!(worst < 0.25 * 0.08 / 800.0, "{worst}");
        let faces = all.as_chunks::<3>().0;
        let varied = faces.iter().filter(|[a, b, c]| a.1 != b.1 || b.1 != c.1).count();
        assert!(varied > 9 * faces.len() / 10);
    }
}

#[test]
fn a_second_cut_interpolates_what_the_first_one_left() {
    let mut half = quarters(NO_DETAIL).swap_remove(0).solid;
    half.name_parent(4);
    let old: Vec<_> = (0..half.surface.len()).filter(|&t| half.surface[t].is_crack()).collect();
    let sites: Vec<Vec3> =
        (0..9).map(|i| Vec3::new(unit(8, 0, i), unit(8, 1, i), unit(8, 2, i))).collect();
    let labels: Vec<u32> = (0..9).collect();
    let again = by_sites(&half, &sites, &labels, &[0.0; 9], &SETTINGS).unwrap();
    assert!(again.parts.len() > 3);
    let mut seen = 0;
    for part in &again.parts {
        for (t, surface) in part.solid.surface.iter().enumerate() {
            let Surface::Crack { damage_time, front_speed, parent: 5 } = *surface else {
                continue;
            };
            let corners = part.solid.mesh.corners(t);
            let middle = corners.iter().sum::<Vec3>() / 3.0;
            let away = |&t: &usize| {
                let q = cullet_geometry::inside::closest_on_triangle(middle, half.mesh.corners(t));
                (q - middle).norm()
            };
            let home = old.iter().copied().min_by(|a, b| away(a).total_cmp(&away(b))).unwrap();
            // The kernel may move slivers a little.
            assert!(away(&home) < 1e-7, "{}", away(&home));
            let wanted = half.surface[home].within(half.mesh.corners(home), corners);
            let Surface::Crack { damage_time: time, front_speed: speed, .. } = wanted else {
                panic!("{wanted:?}");
            };
            for (own, wanted) in [(damage_time, time), (front_speed, speed)] {
                assert!((0..3).all(|k| (own[k] / wanted[k] - 1.0).abs() < 1e-3));
            }
            seen += 1;
        }
    }
    assert!(seen > 100, "{seen}");
}
