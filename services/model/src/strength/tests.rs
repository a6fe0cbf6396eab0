use super::*;

fn points(n: u64, size: f64) -> Vec<Vec3> {
    (0..n).map(|i| Vec3::new(unit(5, 0, i), unit(5, 1, i), unit(5, 2, i)) * size).collect()
}

fn flawless() -> StrengthField {
    StrengthField { weibull: f64::INFINITY, ..StrengthField::default() }
}

#[test]
fn flaws_have_weibulls_distribution_and_mean_one() {
    for m in [5.0, 7.0, 10.0, 20.0] {
        let field = StrengthField { weibull: m, seed: 3, ..StrengthField::default() };
        let strength = Strength::new(&field, 0.01);
        let mut values: Vec<f64> =
            points(20_000, 10.0).iter().map(|x| strength.factor(x)).collect();
        let mean = values.iter().sum::<f64>() / values.len() as f64;
        assert!((mean - 1.0).abs() < 0.01, "m {m}: mean {mean}");
        values.sort_by(f64::total_cmp);
        let scale = libm::tgamma(1.0 + 1.0 / m);
        let expected = |v: f64| 1.0 - libm::exp(-libm::pow(v * scale, m));
        let n = values.len() as f64;
        let gaps = values.iter().enumerate().map(|(i, v)| (i as f64 / n - expected(*v)).abs());
        let gap = gaps.fold(0.0, f64::max);
        assert!(gap < 0.015, "m {m}: the distribution is off by {gap}");
        let low = libm::pow(-libm::log(1.0 - 0.001_349_898), 1.0 / m) / scale;
        assert!((values[0] / low - 1.0).abs() < 1e-6, "m {m}: the tail ends at {}", values[0]);
    }
}

#[test]
fn flaws_are_smooth_over_four_spacings_and_isotropic() {
    let spacing = 0.01;
    let seeded = |seed| StrengthField { seed, ..StrengthField::default() };
    let strengths: Vec<Strength> =
        (0..12).map(|seed| Strength::new(&seeded(seed), spacing)).collect();
    let far = points(1_000, 10.0);
    let correlation = |step: Vec3| {
        let (mut both, mut own) = (0.0, 0.0);
        for (strength, x) in strengths.iter().flat_map(|s| far.iter().map(move |x| (s, x))) {
            let (one, two) = (strength.factor(x) - 1.0, strength.factor(&(x + step)) - 1.0);
            both += one * two;
            own += one * one;
        }
        both / own
    };
    for axis in [Vec3::x(), Vec3::y(), Vec3::new(1.0, 1.0, 1.0).normalize()] {
        let (one, ell) = (correlation(axis * spacing), correlation(axis * CORRELATION * spacing));
        assert!(one > 0.9, "a spacing apart: {one}");
        assert!((ell - 0.37).abs() < 0.08, "a correlation length apart: {ell}");
        assert!(correlation(axis * 4.0 * CORRELATION * spacing).abs() < 0.1);
    }
    let long = StrengthField { correlation: Some(1.0), seed: 9, ..StrengthField::default() };
    let long = Strength::new(&long, spacing);
    let step = long.factor(&far[7]) - long.factor(&(far[7] + Vec3::x() * 0.04));
    assert!(step.abs() < 0.05, "a longer correlation is kept: {step}");
}

#[test]
fn fragments_keep_the_pattern_of_the_body_they_come_from() {
    let whole = StrengthField {
        seed: 4,
        offset: Vec3::new(0.1, 0.0, -0.2),
        weak_plane: Some(PatternWeakPlane { normal: Vec3::z(), ratio: 0.3 }),
        layers: Some(StrengthLayers {
            normal: Vec3::z(),
            thickness: 0.05,
            ratio: 0.5,
            jitter: 0.5,
        }),
        strokes: vec![Stroke {
            region: Region::Sphere { centre: Vec3::x(), radius: 0.5 },
            factor: 0.2,
            edge: 0.1,
        }],
        ..StrengthField::default()
    };
    let centre = Vec3::new(0.4, -0.3, 0.2);
    let moved = StrengthField { offset: whole.offset + centre, ..whole.clone() };
    let (one, two) = (Strength::new(&whole, 0.01), Strength::new(&moved, 0.01));
    for x in points(200, 2.0) {
        assert!((two.factor(&x) - one.factor(&(x + centre))).abs() < 1e-9);
    }
    assert_eq!(two.weak_plane, whole.weak_plane);
}

#[test]
fn layers_alternate_and_their_boundaries_stay_in_order() {
    let layers = |jitter| StrengthLayers { normal: Vec3::y(), thickness: 0.1, ratio: 0.4, jitter };
    let at = |jitter, y: f64| {
        let field = StrengthField { layers: Some(layers(jitter)), ..flawless() };
        Strength::new(&field, 0.01).factor(&Vec3::new(5.0, y, -3.0))
    };
    let plain = [-0.05, 0.05, 0.15, 0.25].map(|y| at(0.0, y));
    assert_eq!(plain, [0.4, 1.0, 0.4, 1.0]);
    let steps: Vec<f64> = (0..4000).map(|i| at(0.9, f64::from(i) * 1e-3 - 2.0)).collect();
    let changes: Vec<usize> = (1..steps.len()).filter(|&i| steps[i] != steps[i - 1]).collect();
    assert!((39..=41).contains(&changes.len()), "{changes:?}");
    let widths: Vec<usize> = changes.windows(2).map(|pair| pair[1] - pair[0]).collect();
    assert!(widths.iter().any(|&w| w < 80) && widths.iter().any(|&w| w > 120), "{widths:?}");
}

#[test]
fn painted_regions_multiply_and_have_soft_edges() {
    let zero = Vec3::zeros();
    let regions = [
        (Region::Box { low: -Vec3::repeat(1.0), high: Vec3::repeat(1.0) }, Vec3::x()),
        (Region::Sphere { centre: zero, radius: 1.0 }, -Vec3::y()),
        (Region::HalfSpace { point: Vec3::z(), normal: Vec3::z() }, Vec3::z()),
        (
            Region::Cylinder { from: zero, to: Vec3::z() * 4.0, radius: 1.0 },
            Vec3::new(0.6, 0.8, 2.0),
        ),
        (Region::Cylinder { from: -Vec3::z(), to: Vec3::z(), radius: 2.0 }, Vec3::z()),
    ];
    for (region, edge) in regions {
        let out = match region {
            Region::Cylinder { from, .. } if from == zero => Vec3::new(0.6, 0.8, 0.0),
            _ => edge.normalize(),
        };
        let stroke = Stroke { region, factor: 0.2, edge: 0.1 };
        let field = StrengthField { strokes: vec![stroke], ..flawless() };
        let at = |step: f64| Strength::new(&field, 0.01).factor(&(edge + out * step));
        assert!((at(0.0) - 0.6).abs() < 1e-9, "{region:?} at its edge: {}", at(0.0));
        assert!((at(-0.06) - 0.2).abs() < 1e-12 && at(0.06) == 1.0, "{region:?}");
        let hard = Stroke { edge: 0.0, ..stroke };
        let twice = StrengthField { strokes: vec![hard, hard], ..flawless() };
        let value = Strength::new(&twice, 0.01).factor(&(edge - out * 0.01));
        assert!((value - 0.04).abs() < 1e-12);
    }
}

#[test]
fn painted_vertices_fade_with_distance() {
    let points: Vec<Vec3> =
        (0..441).map(|i| Vec3::new(f64::from(i % 21), f64::from(i / 21), 0.0) * 0.05).collect();
    let factors = points.iter().map(|p| if p.x < 0.5 { 0.2 } else { 1.0 }).collect();
    let paint = VertexPaint { points, factors, reach: 0.2 };
    let field = StrengthField { vertices: Some(Arc::new(paint)), ..flawless() };
    let strength = Strength::new(&field, 0.01);
    let at = |x: f64, y: f64, z: f64| strength.factor(&Vec3::new(x, y, z));
    assert!((at(0.2, 0.5, 0.0) - 0.2).abs() < 1e-9, "{}", at(0.2, 0.5, 0.0));
    assert_eq!(at(0.8, 0.5, 0.0), 1.0);
    assert_eq!(at(0.2, 0.5, -0.2), 1.0, "deeper than the paint goes");
    assert_eq!(at(-9.0, 0.5, 0.0), 1.0);
    let depths: Vec<f64> = (0..8).map(|i| at(0.2, 0.5, -0.025 * f64::from(i))).collect();
    assert!(depths.is_sorted(), "{depths:?}");
    let across: Vec<f64> = (0..20).map(|i| at(0.3 + 0.02 * f64::from(i), 0.5, 0.0)).collect();
    assert!(across.is_sorted() && across.windows(2).all(|p| p[1] - p[0] < 0.12), "{across:?}");
}

#[test]
fn without_flaws_all_is_one_and_seeds_differ() {
    let plain = Strength::new(&flawless(), 0.01);
    assert!(points(50, 1.0).iter().all(|x| plain.factor(x) == 1.0));
    let seeded = |seed| Strength::new(&StrengthField { seed, ..StrengthField::default() }, 0.01);
    let x = Vec3::new(0.3, 0.1, 0.2);
    assert_ne!(seeded(1).factor(&x), seeded(2).factor(&x));
    assert_eq!(seeded(1).factor(&x).to_bits(), seeded(1).factor(&x).to_bits());
    // The same bits on every machine.
    assert_eq!(format!("{:.15}", seeded(1).factor(&x)), "1.093618315081405");
}

/// A bent line is weak as deep as its groove, at least one and a half spacings wide, and where its
/// grooves overlap it is no weaker.
#[test]
fn a_scored_line_is_weak_below_it_and_nowhere_else() {
    let (a, b, c) = (Vec3::zeros(), Vec3::x(), Vec3::new(1.0, 1.0, 0.0));
    let groove = |from, to| {
        let region = Region::Groove { from, to, inward: -Vec3::z() * 0.1, half_width: 0.0 };
        Stroke { region, factor: 0.2, edge: 0.0 }
    };
    let field = StrengthField { strokes: vec![groove(a, b), groove(b, c)], ..flawless() };
    let spacing = 0.02;
    let strength = Strength::new(&field, spacing);
    let at = |x: f64, y: f64, z: f64| strength.factor(&Vec3::new(x, y, z));
    for (x, y) in [(0.5, 0.0), (1.0, 0.5), (1.0, 0.0), (0.5, 0.7 * spacing)] {
        for z in [0.0, -0.05, -0.1] {
            assert!((at(x, y, z) - 0.2).abs() < 1e-12, "{} at {x} {y} {z}", at(x, y, z));
        }
        assert!((at(x, y, -0.13) - 1.0).abs() < 1e-12, "below it");
    }
    assert!((at(0.5, 0.8 * spacing, 0.0) - 1.0).abs() < 1e-12, "beside it");
    assert!((at(1.1, 1.1, 0.0) - 1.0).abs() < 1e-12, "beyond it");
    assert!((weakest_painted(&field.strokes) - 0.2).abs() < 1e-12, "it counts once");
    let score = strength.score(&Vec3::new(0.5, 0.0, -0.05));
    assert!((score - 0.2).abs() < 1e-12, "as tough as it is strong: {score}");
    assert_eq!(strength.score(&Vec3::new(0.5, 0.5, -0.05)), 1.0);
    let moved = StrengthField { offset: Vec3::new(0.0, 0.0, 5.0), ..field.clone() };
    let grooves = moved.scored(spacing);
    assert!(grooves.len() == 2 && grooves[0].contains(&Vec3::new(0.5, 0.0, -5.05), 0.0));
    assert!(!grooves[0].contains(&Vec3::new(0.5, 0.0, -0.05), spacing));
    let apart = [groove(a, b), groove(c, b)];
    assert!((weakest_painted(&apart) - 0.04).abs() < 1e-12, "two lines");
}
