/** Runs a command. Its error becomes one line, and the exit status 1. */
export async function run(command) {
    try {
        await command();
    } catch (error) {
        console.error(`leadr-three: ${error.message}`);
        process.exitCode = 1;
    }
}
