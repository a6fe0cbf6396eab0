// Compiles jobs with cullet.js as Flamenco's Manager would, with a stub in its place: `node deploy/flamenco/check.js`.
// Prints, as JSON, the tasks of the job with the settings in the first argument, or checks two jobs without one.

const assert = require("assert");
const fs = require("fs");
const path = require("path");
const vm = require("vm");

// What the Manager gives a job type: https://flamenco.blender.org/usage/job-types/
function author() {
    return {
        Task: (name, type) => ({
            name, type, commands: [], dependencies: [],
            addCommand(command) { this.commands.push(command); },
            addDependency(task) { this.dependencies.push(task.name); },
        }),
        Command: (name, parameters) => ({ name, parameters }),
    };
}

function compile(settings) {
    const context = vm.createContext({ author: author(), print: () => {} });
    vm.runInContext(fs.readFileSync(path.join(__dirname, "cullet.js"), "utf8"), context);
    const type = vm.runInContext("JOB_TYPE", context);
    const given = {};
    for (const setting of type.settings) {
        assert(/^[a-z_]+$/.test(setting.key) && ["string", "int32"].includes(setting.type), setting.key);
        const value = settings[setting.key] === undefined ? setting.default : settings[setting.key];
        assert(value !== undefined || !setting.required, "the setting " + setting.key + " is required");
        given[setting.key] = value;
    }
    const tasks = [];
    context.job = { settings: given, addTask: (task) => tasks.push(task) };
    vm.runInContext("compileJob(job)", context);
    return JSON.parse(JSON.stringify(tasks));
}

if (process.argv[2]) {
    console.log(JSON.stringify(compile(JSON.parse(process.argv[2]))));
} else {
    const scene = compile({ source: "pot", output: "out", overrides: "world.seed=3; world.duration=2" });
    assert.strictEqual(scene.length, 1);
    assert.deepStrictEqual(scene[0].commands[0].parameters, {
        exe: "cullet",
        args: ["run", "pot", "--out", "out", "--replace", "--workers", "2",
            "--set", "world.seed=3", "--set", "world.duration=2"],
    });
    const sweep = compile({ source: "sweep.toml", output: "out", runs: 3, workers: 4, times: "0.1,0.3" });
    assert.deepStrictEqual(sweep.map((task) => task.name), ["run-1", "run-2", "run-3", "gather"]);
    assert.deepStrictEqual(sweep[3].dependencies, ["run-1", "run-2", "run-3"]);
    assert.deepStrictEqual(sweep[1].commands[0].parameters.args,
        ["run", "sweep.toml", "--out", "out", "--only", "2", "--replace", "--workers", "4"]);
    assert.deepStrictEqual(sweep[3].commands[0].parameters.args,
        ["run", "sweep.toml", "--out", "out", "--gather", "--at", "0.1,0.3"]);
    console.log("a scene: 1 task; a sweep of 3 runs: 4 tasks");
}
