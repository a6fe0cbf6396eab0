use super::pool::result_of;
use super::*;
use crate::specimen::load;
use cullet_pool::{JobEnding as Settled, Settlement};
use cullet_proto::Verdict;
use cullet_proto::specimen::Frame;

const BAR: &str = r#"
[geometry]
shape = { kind = "box", size = ["10 cm", "2 cm", "2 cm"] }
[material]
name = "stone"
density = 2450
young = "32 GPa"
poisson = 0.2
[solver]
spacing = "1 cm"
breaks = false
[run]
end = "1 ms"
[[probe]]
name = "energy"
kind = "kinetic"
[[metric]]
name = "most"
probe = "energy"
reduce = "max"
[expect.most]
value = 2.0
tolerance = "10 %"
source = "made up"
"#;

fn folder(name: &str) -> tempfile::TempDir {
    let folder = tempfile::tempdir().expect("a folder");
    std::fs::write(folder.path().join(format!("{name}.toml")), BAR).expect("a file");
    folder
}

fn measured(values: Vec<f64>) -> Measured {
    let folder = folder("bar");
    let specimen = load(&folder.path().join("bar.toml"), &[]).expect("it loads");
    let point = SweepPoint { specimen, swept: vec!["seed=3".to_owned()] };
    let mut result = SpecimenResult::ended(Ending::Ok);
    result.outcome.times = (0..values.len()).map(|k| k as f64).collect();
    result.outcome.rows = vec![values];
    Measured::new(point, result)
}

#[test]
fn a_plan_is_every_specimen_with_every_combination() {
    let folder = folder("bar");
    std::fs::write(folder.path().join("other.toml"), BAR).expect("a file");
    let sweeps = ["spacing=1cm,5 mm", "geometry.shift=[0,0,0],[0,0,\"1 mm\"]"];
    let sweeps: Vec<SweptSetting> = sweeps.iter().map(|s| s.parse().expect("a sweep")).collect();
    let points = plan(&[folder.path().to_owned()], &[], &sweeps).expect("a plan");
    assert_eq!(points.len(), 8);
    let last = &points[7];
    assert_eq!(last.specimen.name, "other");
    assert_eq!(last.specimen.job().expect("a body").0.settings.spacing, 0.005);
    assert_eq!(last.specimen.job().expect("a body").0.body.shift.z, 0.001);
    assert_eq!(last.label(), "other[geometry.shift=[0,0,\"1 mm\"]]");
    for bad in ["spacing", "=1", "spacing=1,,2"] {
        assert!(bad.parse::<SweptSetting>().is_err(), "{bad}");
    }
    let empty = tempfile::tempdir().expect("a folder");
    assert!(plan(&[empty.path().to_owned()], &[], &[]).is_err());
}

#[test]
fn a_number_that_is_off_fails_and_one_that_is_near_does_not() {
    let near = measured(vec![0.0, 1.9, 1.0]);
    assert!(!near.fails() && (near.rows[0].value - 1.9).abs() < 1e-15);
    assert!((near.rows[0].weighed.error.expect("an error") + 0.05).abs() < 1e-12);
    assert!(measured(vec![0.0, 1.7]).fails());
    let line = csv(&near);
    assert_eq!(line.trim_end().split(',').count(), COLUMNS.split(',').count());
    assert!(line.starts_with("bar[seed=3],brittle,0.01,"), "{line}");
    assert!(line.contains(",most,1.9,2,-0.05"), "{line}");
    assert!(text(&[near]).contains("-5.00 %"));
}

/// What a metric is over, and what is taken off it, are values of those before.
#[test]
fn a_metric_may_be_over_another() {
    let folder = tempfile::tempdir().expect("a folder");
    let more =
        "[[metric]]\nname = \"share\"\nprobe = \"energy\"\nreduce = \"final\"\nover = \"most\"\n";
    std::fs::write(folder.path().join("bar.toml"), format!("{BAR}{more}")).expect("a file");
    let specimen = load(&folder.path().join("bar.toml"), &[]).expect("it loads");
    let mut result = SpecimenResult::ended(Ending::Ok);
    (result.outcome.times, result.outcome.rows) = (vec![0.0, 1.0, 2.0], vec![vec![0.0, 4.0, 1.0]]);
    let rows = Measured::new(SweepPoint { specimen, swept: Vec::new() }, result).rows;
    assert_eq!((rows[1].metric.as_str(), rows[1].value), ("share", 0.25));
    let wrong = format!("{BAR}{}", more.replace("over = \"most\"", "over = \"mots\""));
    std::fs::write(folder.path().join("bar.toml"), wrong).expect("a file");
    let why = load(&folder.path().join("bar.toml"), &[]).expect_err("there is none").to_string();
    assert!(why.contains("no metric \"mots\" before") && why.contains("most"), "{why}");
}

/// A run that crashed is a line with its status, not a line that is missing.
#[test]
fn a_failed_run_is_a_row() {
    let mut crashed = measured(vec![]);
    crashed =
        Measured::new(crashed.point, SpecimenResult::ended(Ending::Unstable("too hot".to_owned())));
    assert!(crashed.fails());
    assert!(csv(&crashed).ends_with(",most,,2,,unstable\n"), "{}", csv(&crashed));
    assert!(text(&[crashed]).contains("unstable: too hot"));
}

/// What the pool says of a job that came to nothing is a status.
#[test]
fn a_job_without_a_result_is_a_status() {
    let of_late = |ending: Settled, overdue: bool| {
        let wall = std::time::Duration::from_secs(1);
        let settlement = Settlement {
            reproduction: None,
            ending,
            attempts: 1,
            worker: String::new(),
            cached: false,
            overdue,
            wall,
            tries: Vec::new(),
        };
        let limits = Limits { exe: "none".into(), words: Vec::new(), workers: 1, time: wall };
        result_of(settlement, &limits).outcome.ending
    };
    let of = |ending: Settled| of_late(ending, false);
    let told = |ending: &Ending| trouble(ending).unwrap_or_default().to_owned();
    let crash = of(Settled::Abandoned("too many workers ended: signal: 9".to_owned()));
    assert_eq!(status(&crash), "crashed");
    assert!(told(&crash).contains("signal: 9"), "{crash:?}");
    let words = "too many workers ended: over the hard limit";
    let slow = of_late(Settled::Abandoned(words.to_owned()), true);
    assert_eq!(status(&slow), "timeout");
    assert!(told(&slow).contains("1 s, the limit"), "{slow:?}");
    assert_eq!(status(&of(Settled::Abandoned(words.to_owned()))), "crashed");
    assert_eq!(status(&of(Settled::Cancelled)), "crashed");
    let text = "no".to_owned();
    let wrong = of(Settled::Verdict(Verdict::Refused { solver: text.clone(), text }));
    assert!(told(&wrong).contains("answered with Refused"), "{wrong:?}");
    let result = SpecimenResult::ended(Ending::NotFinite("why".to_owned()));
    assert_eq!(status(&of(Settled::Verdict(Verdict::Measured(Box::new(result))))), "nan");
}

/// A sample that is no number is not passed over: what is made of it is none, and is reported so.
#[test]
fn a_sample_that_is_no_number_makes_the_metric_none() {
    let spoiled = measured(vec![0.0, f64::NAN, 2.0]);
    assert!(spoiled.rows[0].value.is_nan() && spoiled.rows[0].spoiled && spoiled.fails());
    assert!(csv(&spoiled).ends_with(",most,,2,,nan\n"), "{}", csv(&spoiled));
    assert!(text(&[spoiled]).contains("nan"));
    let whole = measured(vec![0.0, 1.0, 2.0]);
    assert!(!whole.rows[0].spoiled && csv(&whole).ends_with(",ok\n"));
}

/// Runs whose names are the same, or become so as files, keep their files apart.
#[test]
fn no_two_runs_write_the_same_files() {
    let mut points: Vec<SweepPoint> = (0..5).map(|_| measured(vec![]).point).collect();
    let swept = ["a=1 mm", "a=1_mm", "a=1_MM", "a=2", "a=1_mm.2"];
    points.iter_mut().zip(swept).for_each(|(point, text)| point.swept = vec![text.to_owned()]);
    let names = file_names(&points);
    let wanted = ["bar.a-1_mm", "bar.a-1_mm.2", "bar.a-1_MM.3", "bar.a-2", "bar.a-1_mm.2.2"];
    assert_eq!(names, wanted);
}

#[test]
fn a_run_leaves_its_samples_its_points_and_their_picture() {
    let folder = tempfile::tempdir().expect("a folder");
    let mut run = measured(vec![1.0, 2.0]);
    let point = |k: u32| [k as f32 * 0.01, (k % 7) as f32 * 0.01, 0.0, k as f32];
    let frame = |time| Frame { time, points: (0..50).map(point).collect() };
    run.result.frames = [0.0, 0.5, 1.0].map(frame).to_vec();
    let name = file_names(std::slice::from_ref(&run.point)).remove(0);
    run.save(folder.path(), &name, None).expect("it is written");
    let text = |name: &str| std::fs::read(folder.path().join(name)).expect("a file");
    let csv = String::from_utf8(text("bar.seed-3.csv")).expect("text");
    assert_eq!(csv.lines().collect::<Vec<_>>(), ["time [s],energy [J]", "0,1", "1,2"]);
    assert!(text("bar.seed-3.png").starts_with(b"\x89PNG"));
    let bytes = text("bar.seed-3.mcap");
    assert!(bytes.starts_with(b"\x89MCAP") && bytes.ends_with(b"MCAP0\r\n"));
}
