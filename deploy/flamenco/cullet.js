// Cullet as a job type of Flamenco (https://flamenco.blender.org/usage/job-types/): copy this file to `scripts` beside
// the Manager's program. Scenes and results lie on the storage that all workers see, and each worker has `cullet`.
// `node deploy/flamenco/check.js` compiles jobs with it; it was not run in Flamenco. See docs/batch.md.

const JOB_TYPE = {
    label: "Cullet",
    description: "Run a scene of things that break, or the runs of a sweep as one task each",
    settings: [
        {
            key: "source", label: "Scene or sweep", type: "string", subtype: "file_path", required: true,
            description: "A scene file, a folder with a scene.toml, or a sweep file",
        },
        {
            key: "runs", label: "Runs", type: "int32", default: 0, propargs: { min: 0, max: 1000 },
            description: "Number of runs of the sweep, as `cullet check` prints it; 0: it is a scene",
        },
        {
            key: "output", label: "Results", type: "string", subtype: "dir_path", required: true,
            description: "Folder for the results; what an earlier try left there is replaced",
        },
        {
            key: "workers", label: "Workers", type: "int32", default: 2, propargs: { min: 1, max: 256 },
            description: "Worker processes of a run; they change no result",
        },
        {
            key: "overrides", label: "Overrides", type: "string", default: "",
            description: "Values to override, as PATH=VALUE, with semicolons between them",
        },
        {
            key: "times", label: "Sheet at", type: "string", default: "",
            description: "Times that the sheet of a sweep shows, in seconds, such as 0.1,0.3; empty: the first break",
        },
        {
            key: "program", label: "Program", type: "string", default: "cullet",
            description: "The program: on the path of the workers, or where it is",
        },
    ],
};

function compileJob(job) {
    const settings = job.settings;
    const runs = Number(settings.runs || 0);
    if (runs === 0) {
        job.addTask(runTask("run", settings, replacing(settings)));
        return;
    }
    const tasks = [];
    for (let run = 1; run <= runs; run++) {
        tasks.push(runTask("run-" + run, settings, ["--only", String(run)].concat(replacing(settings))));
    }
    const times = String(settings.times || "").trim();
    const gather = runTask("gather", settings, ["--gather"].concat(times ? ["--at", times] : []));
    for (const task of tasks) {
        job.addTask(task);
        gather.addDependency(task);
    }
    job.addTask(gather);
}

// A task that is tried again begins anew.
function replacing(settings) {
    return ["--replace", "--workers", String(settings.workers || 2)];
}

// One call of `cullet run`.
function runTask(name, settings, more) {
    const args = ["run", settings.source, "--out", settings.output].concat(more);
    for (const value of String(settings.overrides || "").split(";")) {
        if (value.trim()) {
            args.push("--set", value.trim());
        }
    }
    const task = author.Task(name, "misc");
    task.addCommand(author.Command("exec", { exe: settings.program || "cullet", args: args }));
    return task;
}
