
using namespace System.Management.Automation
using namespace System.Management.Automation.Language

Register-ArgumentCompleter -Native -CommandName 'splineway' -ScriptBlock {
    param($wordToComplete, $commandAst, $cursorPosition)

    $commandElements = $commandAst.CommandElements
    $command = @(
        'splineway'
        for ($i = 1; $i -lt $commandElements.Count; $i++) {
            $element = $commandElements[$i]
            if ($element -isnot [StringConstantExpressionAst] -or
                $element.StringConstantType -ne [StringConstantType]::BareWord -or
                $element.Value.StartsWith('-') -or
                $element.Value -eq $wordToComplete) {
                break
        }
        $element.Value
    }) -join ';'

    $completions = @(switch ($command) {
        'splineway' {
            [CompletionResult]::new('-h', '-h', [CompletionResultType]::ParameterName, 'Print help')
            [CompletionResult]::new('--help', '--help', [CompletionResultType]::ParameterName, 'Print help')
            [CompletionResult]::new('-V', '-V ', [CompletionResultType]::ParameterName, 'Print version')
            [CompletionResult]::new('--version', '--version', [CompletionResultType]::ParameterName, 'Print version')
            [CompletionResult]::new('simulate', 'simulate', [CompletionResultType]::ParameterValue, 'Runs a tool path through the motion core and judges every servo cycle')
            [CompletionResult]::new('check', 'check', [CompletionResultType]::ParameterValue, 'Says what the core will do with a program: what was noticed while reading it, how long it takes, where the time goes, and the places that lose most of it')
            [CompletionResult]::new('stream', 'stream', [CompletionResultType]::ParameterValue, 'Sends a program to a controller and waits until it has been run')
            [CompletionResult]::new('controller', 'controller', [CompletionResultType]::ParameterValue, 'Runs the core as firmware does, on a pseudo-terminal or a TCP port, with the same protocols and no machine')
            [CompletionResult]::new('machine', 'machine', [CompletionResultType]::ParameterValue, 'Prints the machine that is used where none is described, as a description (TOML) to begin with: every key with its unit, and as comments what else a machine may have')
            [CompletionResult]::new('gcodes', 'gcodes', [CompletionResultType]::ParameterValue, 'Lists the G-codes that are read, as the reader''s own tables have them')
            [CompletionResult]::new('formats', 'formats', [CompletionResultType]::ParameterValue, 'Lists the files that are read and written: programs, machines, operator''s commands, setpoints, reports')
            [CompletionResult]::new('smooth', 'smooth', [CompletionResultType]::ParameterValue, 'Smooths a B-spline tool path inside the tolerance tube around it, and reports curvature, length, feed and machining time before and after')
            [CompletionResult]::new('bench', 'bench', [CompletionResultType]::ParameterValue, 'Runs tool paths through the core in both number types, judges them, and prints times beside those of other speed laws, with memory and cost')
            [CompletionResult]::new('soak', 'soak', [CompletionResultType]::ParameterValue, 'Runs random programs on random machines while an operator presses anything at any moment, the interrupt comes in between any two accesses to shared state and the background is late; and holds every servo cycle, command and answer against the rules')
            [CompletionResult]::new('limit', 'limit', [CompletionResultType]::ParameterValue, 'Finds the least time of any motion inside the band of a tool path, shape and speed together, and says how near to it the planned motion is. It takes some seconds of work for every second of motion. What it finds can be reached, for the judge looks at it; that nothing is faster is not proven')
            [CompletionResult]::new('reshape', 'reshape', [CompletionResultType]::ParameterValue, 'Plans a tool path, improves shape and speed of the planned motion together inside the band, window by window as a controller would, and judges what comes out. The controllers themselves do not do this yet')
            [CompletionResult]::new('corners', 'corners', [CompletionResultType]::ParameterValue, 'Compares corner transitions at equal deviation: smoothness, time, effort')
            [CompletionResult]::new('paper', 'paper', [CompletionResultType]::ParameterValue, 'Works out the routines of Guo, Yan, Wang 2023 as printed, runs the paths of the paper through the core in paper mode and in its own, and prints the figures side by side, with those of the paper''s list of further work')
            [CompletionResult]::new('thesis', 'thesis', [CompletionResultType]::ParameterValue, 'Smooths the cases of Naseath 2007 (equivalents) and the ripples of its section 3.12 as printed and in bounded sweeps, prints tables 4-1 to 4-7 beside the printed ones, and counts the figures that come out')
            [CompletionResult]::new('completions', 'completions', [CompletionResultType]::ParameterValue, 'Prints a script that completes this program''s arguments in a shell')
            [CompletionResult]::new('help', 'help', [CompletionResultType]::ParameterValue, 'Print this message or the help of the given subcommand(s)')
            break
        }
        'splineway;simulate' {
            [CompletionResult]::new('--machine', '--machine', [CompletionResultType]::ParameterName, 'Machine description (TOML) [default: a small milling machine, which `splineway machine` prints]')
            [CompletionResult]::new('--feed', '--feed', [CompletionResultType]::ParameterName, 'Feed of all moves but rapids, mm/s, in place of what the file says [default: the file''s; 50 where it says nothing]')
            [CompletionResult]::new('--dialect', '--dialect', [CompletionResultType]::ParameterName, 'Whose G-code it is [default: told by comments and codes of the first 1000 lines where that is plain, else linuxcnc]')
            [CompletionResult]::new('--tolerance', '--tolerance', [CompletionResultType]::ParameterName, 'Greatest distance from the programmed path, mm, in place of the machine''s, and of those that the program names (G64 P) [default: those]')
            [CompletionResult]::new('--cycle', '--cycle', [CompletionResultType]::ParameterName, 'Servo cycle, s [default: the machine''s]')
            [CompletionResult]::new('--lookahead', '--lookahead', [CompletionResultType]::ParameterName, 'Look-ahead depth, blocks: 16, 64 or 256 [default: the machine''s]')
            [CompletionResult]::new('--sweeps', '--sweeps', [CompletionResultType]::ParameterName, 'Smoothing sweeps over runs of short lines; 0 leaves them as they are laid [default: the machine''s]')
            [CompletionResult]::new('--scalar', '--scalar', [CompletionResultType]::ParameterName, 'Number type of the core')
            [CompletionResult]::new('--mode', '--mode', [CompletionResultType]::ParameterName, 'How corners are rounded [default: the machine''s]')
            [CompletionResult]::new('--lambda', '--lambda', [CompletionResultType]::ParameterName, 'Share of what is left of a line that stays straight between two of its corners, in paper mode, 0 to 0.99 [default: the machine''s]')
            [CompletionResult]::new('--segments', '--segments', [CompletionResultType]::ParameterName, 'Runs a NURBS curve as so many chords of equal parameter steps [default: as the curve itself]')
            [CompletionResult]::new('--events', '--events', [CompletionResultType]::ParameterName, 'Operator''s commands: lines "time, action[, value]"; `splineway formats` lists the actions [default: none]')
            [CompletionResult]::new('--setpoints', '--setpoints', [CompletionResultType]::ParameterName, 'Writes setpoints, one row per servo cycle (CSV) [default: not written]')
            [CompletionResult]::new('--report', '--report', [CompletionResultType]::ParameterName, 'Writes figures of the run (JSON) [default: not written]')
            [CompletionResult]::new('--plot', '--plot', [CompletionResultType]::ParameterName, 'Writes a plot (.html, .svg or .png) [default: not written]')
            [CompletionResult]::new('--lenient', '--lenient', [CompletionResultType]::ParameterName, 'Leave out codes that cannot change where the tool goes, where they would be refused')
            [CompletionResult]::new('--block-delete', '--block-delete', [CompletionResultType]::ParameterName, 'Leave out lines that begin with "/"')
            [CompletionResult]::new('--reshape', '--reshape', [CompletionResultType]::ParameterName, 'Improves shape and speed of the motion together, inside the band [default: the machine''s]')
            [CompletionResult]::new('--open', '--open', [CompletionResultType]::ParameterName, 'Opens the plot; if --plot does not say where it goes, a page in the folder for temporary files')
            [CompletionResult]::new('--compare', '--compare', [CompletionResultType]::ParameterName, 'Prints other speed laws on the same path beside this planner; the plot then shows their speeds along the way')
            [CompletionResult]::new('--json', '--json', [CompletionResultType]::ParameterName, 'Print the figures of the run as JSON')
            [CompletionResult]::new('--quiet', '--quiet', [CompletionResultType]::ParameterName, 'Print nothing but errors')
            [CompletionResult]::new('-h', '-h', [CompletionResultType]::ParameterName, 'Print help (see more with ''--help'')')
            [CompletionResult]::new('--help', '--help', [CompletionResultType]::ParameterName, 'Print help (see more with ''--help'')')
            break
        }
        'splineway;check' {
            [CompletionResult]::new('--machine', '--machine', [CompletionResultType]::ParameterName, 'Machine description (TOML) [default: a small milling machine, which `splineway machine` prints]')
            [CompletionResult]::new('--feed', '--feed', [CompletionResultType]::ParameterName, 'Feed of all moves but rapids, mm/s, in place of what the file says [default: the file''s; 50 where it says nothing]')
            [CompletionResult]::new('--dialect', '--dialect', [CompletionResultType]::ParameterName, 'Whose G-code it is [default: told by comments and codes of the first 1000 lines where that is plain, else linuxcnc]')
            [CompletionResult]::new('--tolerance', '--tolerance', [CompletionResultType]::ParameterName, 'Greatest distance from the programmed path, mm, in place of the machine''s, and of those that the program names (G64 P) [default: those]')
            [CompletionResult]::new('--places', '--places', [CompletionResultType]::ParameterName, 'How many slow places are shown')
            [CompletionResult]::new('--lenient', '--lenient', [CompletionResultType]::ParameterName, 'Leave out codes that cannot change where the tool goes, where they would be refused')
            [CompletionResult]::new('--block-delete', '--block-delete', [CompletionResultType]::ParameterName, 'Leave out lines that begin with "/"')
            [CompletionResult]::new('--json', '--json', [CompletionResultType]::ParameterName, 'Print JSON')
            [CompletionResult]::new('--quiet', '--quiet', [CompletionResultType]::ParameterName, 'Print nothing but warnings and errors')
            [CompletionResult]::new('-h', '-h', [CompletionResultType]::ParameterName, 'Print help (see more with ''--help'')')
            [CompletionResult]::new('--help', '--help', [CompletionResultType]::ParameterName, 'Print help (see more with ''--help'')')
            break
        }
        'splineway;stream' {
            [CompletionResult]::new('--port', '--port', [CompletionResultType]::ParameterName, 'The serial port. It is locked: one sender at a time')
            [CompletionResult]::new('--baud', '--baud', [CompletionResultType]::ParameterName, 'Bits per second')
            [CompletionResult]::new('--watchdog', '--watchdog', [CompletionResultType]::ParameterName, 'Silence of this program after which the controller stops the machine, s, 0.1 to 60; 0: never')
            [CompletionResult]::new('--home', '--home', [CompletionResultType]::ParameterName, 'How axes are homed at a line `$H` of the program, mm and mm/s: "X-40 Y-20 slow 4 reach 300 back 2 at 0 park 5" [default: none]')
            [CompletionResult]::new('--laser', '--laser', [CompletionResultType]::ParameterName, 'S and M3 to M5 are those of a laser with this greatest power [default: none]')
            [CompletionResult]::new('--machine', '--machine', [CompletionResultType]::ParameterName, 'Machine description (TOML) [default: a small milling machine, which `splineway machine` prints]')
            [CompletionResult]::new('--feed', '--feed', [CompletionResultType]::ParameterName, 'Feed of all moves but rapids, mm/s, in place of what the file says [default: the file''s; 50 where it says nothing]')
            [CompletionResult]::new('--dialect', '--dialect', [CompletionResultType]::ParameterName, 'Whose G-code it is [default: told by comments and codes of the first 1000 lines where that is plain, else linuxcnc]')
            [CompletionResult]::new('--approach', '--approach', [CompletionResultType]::ParameterName, 'Move straight to the first point of a path that does not begin where the machine stands')
            [CompletionResult]::new('--abort', '--abort', [CompletionResultType]::ParameterName, 'Abort what a program before has left whose sender is gone')
            [CompletionResult]::new('--outputs', '--outputs', [CompletionResultType]::ParameterName, 'Switch outputs in time with the path by M62 to M68; without it M62 to M65 are events')
            [CompletionResult]::new('--json', '--json', [CompletionResultType]::ParameterName, 'Print what came of it as JSON')
            [CompletionResult]::new('--quiet', '--quiet', [CompletionResultType]::ParameterName, 'Print nothing but errors')
            [CompletionResult]::new('--lenient', '--lenient', [CompletionResultType]::ParameterName, 'Leave out codes that cannot change where the tool goes, where they would be refused')
            [CompletionResult]::new('--block-delete', '--block-delete', [CompletionResultType]::ParameterName, 'Leave out lines that begin with "/"')
            [CompletionResult]::new('-h', '-h', [CompletionResultType]::ParameterName, 'Print help (see more with ''--help'')')
            [CompletionResult]::new('--help', '--help', [CompletionResultType]::ParameterName, 'Print help (see more with ''--help'')')
            break
        }
        'splineway;controller' {
            [CompletionResult]::new('--axes', '--axes', [CompletionResultType]::ParameterName, 'Axes: 3, 6 or 9')
            [CompletionResult]::new('--protocol', '--protocol', [CompletionResultType]::ParameterName, 'What it speaks')
            [CompletionResult]::new('--tcp', '--tcp', [CompletionResultType]::ParameterName, 'Listen on this TCP port of this computer; 0 takes a free one [default: a pseudo-terminal]')
            [CompletionResult]::new('--settings', '--settings', [CompletionResultType]::ParameterName, 'Keep the settings of grbl in this file [default: in memory]')
            [CompletionResult]::new('--machine', '--machine', [CompletionResultType]::ParameterName, 'Machine description (TOML) [default: a small milling machine, which `splineway machine` prints]')
            [CompletionResult]::new('--switch', '--switch', [CompletionResultType]::ParameterName, 'A home switch, closed beyond a place, as "X>5" (mm, the machine being switched on at 0); more than those of the machine''s file [default: none]')
            [CompletionResult]::new('--surface', '--surface', [CompletionResultType]::ParameterName, 'A surface that the probe meets there, as "Z<-20" [default: none]')
            [CompletionResult]::new('--speed', '--speed', [CompletionResultType]::ParameterName, 'How many times faster than the clock it runs')
            [CompletionResult]::new('--faults', '--faults', [CompletionResultType]::ParameterName, 'Share of the bytes that are lost, garbled or doubled, in either direction')
            [CompletionResult]::new('--once', '--once', [CompletionResultType]::ParameterName, 'End after the first program')
            [CompletionResult]::new('-h', '-h', [CompletionResultType]::ParameterName, 'Print help (see more with ''--help'')')
            [CompletionResult]::new('--help', '--help', [CompletionResultType]::ParameterName, 'Print help (see more with ''--help'')')
            break
        }
        'splineway;machine' {
            [CompletionResult]::new('-h', '-h', [CompletionResultType]::ParameterName, 'Print help')
            [CompletionResult]::new('--help', '--help', [CompletionResultType]::ParameterName, 'Print help')
            break
        }
        'splineway;gcodes' {
            [CompletionResult]::new('--dialect', '--dialect', [CompletionResultType]::ParameterName, 'Whose G-code')
            [CompletionResult]::new('--all', '--all', [CompletionResultType]::ParameterName, 'Also list what is refused by name, and what is left out')
            [CompletionResult]::new('--json', '--json', [CompletionResultType]::ParameterName, 'Print JSON')
            [CompletionResult]::new('-h', '-h', [CompletionResultType]::ParameterName, 'Print help (see more with ''--help'')')
            [CompletionResult]::new('--help', '--help', [CompletionResultType]::ParameterName, 'Print help (see more with ''--help'')')
            break
        }
        'splineway;formats' {
            [CompletionResult]::new('-h', '-h', [CompletionResultType]::ParameterName, 'Print help')
            [CompletionResult]::new('--help', '--help', [CompletionResultType]::ParameterName, 'Print help')
            break
        }
        'splineway;smooth' {
            [CompletionResult]::new('--tolerance', '--tolerance', [CompletionResultType]::ParameterName, 'Radius of the tube, mm [default: the file''s]')
            [CompletionResult]::new('--precision', '--precision', [CompletionResultType]::ParameterName, 'Places per knot interval at which the thesis''s method takes distances [default: the file''s, or 5]')
            [CompletionResult]::new('--accuracy', '--accuracy', [CompletionResultType]::ParameterName, 'Share of the radius within which the thesis''s method ends [default: the file''s, or 0.01]')
            [CompletionResult]::new('--iterations', '--iterations', [CompletionResultType]::ParameterName, 'Most iterations of the thesis''s method, or sweeps per pass of the bounded one [default: 1000 iterations, 16 sweeps]')
            [CompletionResult]::new('--method', '--method', [CompletionResultType]::ParameterName, 'How to smooth')
            [CompletionResult]::new('--feed', '--feed', [CompletionResultType]::ParameterName, 'Feed of the motion along it, mm/s, in place of what the file says [default: the file''s; 400 where it says nothing]')
            [CompletionResult]::new('--acceleration', '--acceleration', [CompletionResultType]::ParameterName, 'Its acceleration, mm/s2')
            [CompletionResult]::new('--jerk', '--jerk', [CompletionResultType]::ParameterName, 'Its jerk, mm/s3')
            [CompletionResult]::new('--reading', '--reading', [CompletionResultType]::ParameterName, 'How section 4.5 of the thesis is read')
            [CompletionResult]::new('--out', '--out', [CompletionResultType]::ParameterName, 'Writes the smoothed spline (.json, .toml or .txt) [default: not written]')
            [CompletionResult]::new('--report', '--report', [CompletionResultType]::ParameterName, 'Writes figures and profiles (JSON) [default: not written]')
            [CompletionResult]::new('--plot', '--plot', [CompletionResultType]::ParameterName, 'Writes a plot (.html, .svg or .png) [default: not written]')
            [CompletionResult]::new('--closed', '--closed', [CompletionResultType]::ParameterName, 'The spline is closed: the knots are its intervals')
            [CompletionResult]::new('--json', '--json', [CompletionResultType]::ParameterName, 'Print the figures, without the profiles, as JSON')
            [CompletionResult]::new('-h', '-h', [CompletionResultType]::ParameterName, 'Print help (see more with ''--help'')')
            [CompletionResult]::new('--help', '--help', [CompletionResultType]::ParameterName, 'Print help (see more with ''--help'')')
            break
        }
        'splineway;bench' {
            [CompletionResult]::new('--json', '--json', [CompletionResultType]::ParameterName, 'Print JSON')
            [CompletionResult]::new('-h', '-h', [CompletionResultType]::ParameterName, 'Print help')
            [CompletionResult]::new('--help', '--help', [CompletionResultType]::ParameterName, 'Print help')
            break
        }
        'splineway;soak' {
            [CompletionResult]::new('--cases', '--cases', [CompletionResultType]::ParameterName, 'Cases to be run')
            [CompletionResult]::new('--seed', '--seed', [CompletionResultType]::ParameterName, 'Number of the first case; the same numbers give the same cases')
            [CompletionResult]::new('--threads', '--threads', [CompletionResultType]::ParameterName, 'Threads [default: as many as the machine has cores]')
            [CompletionResult]::new('--case', '--case', [CompletionResultType]::ParameterName, 'Runs this case alone, and tells what happens in it [default: all of them]')
            [CompletionResult]::new('--plant', '--plant', [CompletionResultType]::ParameterName, 'Puts a bug between the core and the rest, to see whether it is found (0: the first of the list) [default: none]')
            [CompletionResult]::new('--shrink', '--shrink', [CompletionResultType]::ParameterName, 'Shows the least case that breaks the same rule')
            [CompletionResult]::new('--json', '--json', [CompletionResultType]::ParameterName, 'Print JSON')
            [CompletionResult]::new('--quiet', '--quiet', [CompletionResultType]::ParameterName, 'Print nothing but what was broken')
            [CompletionResult]::new('-h', '-h', [CompletionResultType]::ParameterName, 'Print help')
            [CompletionResult]::new('--help', '--help', [CompletionResultType]::ParameterName, 'Print help')
            break
        }
        'splineway;limit' {
            [CompletionResult]::new('--machine', '--machine', [CompletionResultType]::ParameterName, 'Machine description (TOML) [default: a small milling machine, which `splineway machine` prints]')
            [CompletionResult]::new('--feed', '--feed', [CompletionResultType]::ParameterName, 'Feed of all moves but rapids, mm/s, in place of what the file says [default: the file''s; 50 where it says nothing]')
            [CompletionResult]::new('--dialect', '--dialect', [CompletionResultType]::ParameterName, 'Whose G-code it is [default: told by comments and codes of the first 1000 lines where that is plain, else linuxcnc]')
            [CompletionResult]::new('--tolerance', '--tolerance', [CompletionResultType]::ParameterName, 'Greatest distance from the programmed path, mm, in place of the machine''s, and of those that the program names (G64 P) [default: those]')
            [CompletionResult]::new('--step', '--step', [CompletionResultType]::ParameterName, 'Time between the knots of the motion, ms')
            [CompletionResult]::new('--rounds', '--rounds', [CompletionResultType]::ParameterName, 'Most rounds')
            [CompletionResult]::new('--longest', '--longest', [CompletionResultType]::ParameterName, 'Longest motion that is looked at, s')
            [CompletionResult]::new('--setpoints', '--setpoints', [CompletionResultType]::ParameterName, 'Writes the setpoints of the motion found (CSV; one file only) [default: not written]')
            [CompletionResult]::new('--lenient', '--lenient', [CompletionResultType]::ParameterName, 'Leave out codes that cannot change where the tool goes, where they would be refused')
            [CompletionResult]::new('--block-delete', '--block-delete', [CompletionResultType]::ParameterName, 'Leave out lines that begin with "/"')
            [CompletionResult]::new('--json', '--json', [CompletionResultType]::ParameterName, 'Print JSON')
            [CompletionResult]::new('-h', '-h', [CompletionResultType]::ParameterName, 'Print help (see more with ''--help'')')
            [CompletionResult]::new('--help', '--help', [CompletionResultType]::ParameterName, 'Print help (see more with ''--help'')')
            break
        }
        'splineway;reshape' {
            [CompletionResult]::new('--machine', '--machine', [CompletionResultType]::ParameterName, 'Machine description (TOML) [default: a small milling machine, which `splineway machine` prints]')
            [CompletionResult]::new('--feed', '--feed', [CompletionResultType]::ParameterName, 'Feed of all moves but rapids, mm/s, in place of what the file says [default: the file''s; 50 where it says nothing]')
            [CompletionResult]::new('--dialect', '--dialect', [CompletionResultType]::ParameterName, 'Whose G-code it is [default: told by comments and codes of the first 1000 lines where that is plain, else linuxcnc]')
            [CompletionResult]::new('--tolerance', '--tolerance', [CompletionResultType]::ParameterName, 'Greatest distance from the programmed path, mm, in place of the machine''s, and of those that the program names (G64 P) [default: those]')
            [CompletionResult]::new('--precision', '--precision', [CompletionResultType]::ParameterName, 'Scalar of the windows; the planned motion is of double precision')
            [CompletionResult]::new('--setpoints', '--setpoints', [CompletionResultType]::ParameterName, 'Writes the setpoints of the improved motion (CSV; one file only) [default: not written]')
            [CompletionResult]::new('--lenient', '--lenient', [CompletionResultType]::ParameterName, 'Leave out codes that cannot change where the tool goes, where they would be refused')
            [CompletionResult]::new('--block-delete', '--block-delete', [CompletionResultType]::ParameterName, 'Leave out lines that begin with "/"')
            [CompletionResult]::new('--json', '--json', [CompletionResultType]::ParameterName, 'Print JSON')
            [CompletionResult]::new('-h', '-h', [CompletionResultType]::ParameterName, 'Print help (see more with ''--help'')')
            [CompletionResult]::new('--help', '--help', [CompletionResultType]::ParameterName, 'Print help (see more with ''--help'')')
            break
        }
        'splineway;corners' {
            [CompletionResult]::new('--tolerance', '--tolerance', [CompletionResultType]::ParameterName, 'True deviation of every transition from the corner''s legs, mm, up to 0.2')
            [CompletionResult]::new('--turns', '--turns', [CompletionResultType]::ParameterName, 'Turns, 15 to 155 degrees, with commas between: 30,60')
            [CompletionResult]::new('--machine', '--machine', [CompletionResultType]::ParameterName, 'Machine description (TOML), whose default axis counts [default: a small milling machine, which `splineway machine` prints]')
            [CompletionResult]::new('--json', '--json', [CompletionResultType]::ParameterName, 'Print JSON')
            [CompletionResult]::new('-h', '-h', [CompletionResultType]::ParameterName, 'Print help')
            [CompletionResult]::new('--help', '--help', [CompletionResultType]::ParameterName, 'Print help')
            break
        }
        'splineway;paper' {
            [CompletionResult]::new('--plots', '--plots', [CompletionResultType]::ParameterName, 'Writes pictures into this folder: the curvature profiles of figure 13b, and corners as in figure 12b (SVG) [default: not written]')
            [CompletionResult]::new('--json', '--json', [CompletionResultType]::ParameterName, 'Print JSON')
            [CompletionResult]::new('-h', '-h', [CompletionResultType]::ParameterName, 'Print help')
            [CompletionResult]::new('--help', '--help', [CompletionResultType]::ParameterName, 'Print help')
            break
        }
        'splineway;thesis' {
            [CompletionResult]::new('--plateau', '--plateau', [CompletionResultType]::ParameterName, 'What a plateau of the speed is when section 4.5 is read word by word')
            [CompletionResult]::new('--plots', '--plots', [CompletionResultType]::ParameterName, 'Writes figures 3-26, 3-27 and 4-8 to 4-31 into this folder [default: not written]')
            [CompletionResult]::new('--json', '--json', [CompletionResultType]::ParameterName, 'Print the figures of every case as JSON')
            [CompletionResult]::new('-h', '-h', [CompletionResultType]::ParameterName, 'Print help (see more with ''--help'')')
            [CompletionResult]::new('--help', '--help', [CompletionResultType]::ParameterName, 'Print help (see more with ''--help'')')
            break
        }
        'splineway;completions' {
            [CompletionResult]::new('-h', '-h', [CompletionResultType]::ParameterName, 'Print help')
            [CompletionResult]::new('--help', '--help', [CompletionResultType]::ParameterName, 'Print help')
            break
        }
        'splineway;help' {
            [CompletionResult]::new('simulate', 'simulate', [CompletionResultType]::ParameterValue, 'Runs a tool path through the motion core and judges every servo cycle')
            [CompletionResult]::new('check', 'check', [CompletionResultType]::ParameterValue, 'Says what the core will do with a program: what was noticed while reading it, how long it takes, where the time goes, and the places that lose most of it')
            [CompletionResult]::new('stream', 'stream', [CompletionResultType]::ParameterValue, 'Sends a program to a controller and waits until it has been run')
            [CompletionResult]::new('controller', 'controller', [CompletionResultType]::ParameterValue, 'Runs the core as firmware does, on a pseudo-terminal or a TCP port, with the same protocols and no machine')
            [CompletionResult]::new('machine', 'machine', [CompletionResultType]::ParameterValue, 'Prints the machine that is used where none is described, as a description (TOML) to begin with: every key with its unit, and as comments what else a machine may have')
            [CompletionResult]::new('gcodes', 'gcodes', [CompletionResultType]::ParameterValue, 'Lists the G-codes that are read, as the reader''s own tables have them')
            [CompletionResult]::new('formats', 'formats', [CompletionResultType]::ParameterValue, 'Lists the files that are read and written: programs, machines, operator''s commands, setpoints, reports')
            [CompletionResult]::new('smooth', 'smooth', [CompletionResultType]::ParameterValue, 'Smooths a B-spline tool path inside the tolerance tube around it, and reports curvature, length, feed and machining time before and after')
            [CompletionResult]::new('bench', 'bench', [CompletionResultType]::ParameterValue, 'Runs tool paths through the core in both number types, judges them, and prints times beside those of other speed laws, with memory and cost')
            [CompletionResult]::new('soak', 'soak', [CompletionResultType]::ParameterValue, 'Runs random programs on random machines while an operator presses anything at any moment, the interrupt comes in between any two accesses to shared state and the background is late; and holds every servo cycle, command and answer against the rules')
            [CompletionResult]::new('limit', 'limit', [CompletionResultType]::ParameterValue, 'Finds the least time of any motion inside the band of a tool path, shape and speed together, and says how near to it the planned motion is. It takes some seconds of work for every second of motion. What it finds can be reached, for the judge looks at it; that nothing is faster is not proven')
            [CompletionResult]::new('reshape', 'reshape', [CompletionResultType]::ParameterValue, 'Plans a tool path, improves shape and speed of the planned motion together inside the band, window by window as a controller would, and judges what comes out. The controllers themselves do not do this yet')
            [CompletionResult]::new('corners', 'corners', [CompletionResultType]::ParameterValue, 'Compares corner transitions at equal deviation: smoothness, time, effort')
            [CompletionResult]::new('paper', 'paper', [CompletionResultType]::ParameterValue, 'Works out the routines of Guo, Yan, Wang 2023 as printed, runs the paths of the paper through the core in paper mode and in its own, and prints the figures side by side, with those of the paper''s list of further work')
            [CompletionResult]::new('thesis', 'thesis', [CompletionResultType]::ParameterValue, 'Smooths the cases of Naseath 2007 (equivalents) and the ripples of its section 3.12 as printed and in bounded sweeps, prints tables 4-1 to 4-7 beside the printed ones, and counts the figures that come out')
            [CompletionResult]::new('completions', 'completions', [CompletionResultType]::ParameterValue, 'Prints a script that completes this program''s arguments in a shell')
            [CompletionResult]::new('help', 'help', [CompletionResultType]::ParameterValue, 'Print this message or the help of the given subcommand(s)')
            break
        }
        'splineway;help;simulate' {
            break
        }
        'splineway;help;check' {
            break
        }
        'splineway;help;stream' {
            break
        }
        'splineway;help;controller' {
            break
        }
        'splineway;help;machine' {
            break
        }
        'splineway;help;gcodes' {
            break
        }
        'splineway;help;formats' {
            break
        }
        'splineway;help;smooth' {
            break
        }
        'splineway;help;bench' {
            break
        }
        'splineway;help;soak' {
            break
        }
        'splineway;help;limit' {
            break
        }
        'splineway;help;reshape' {
            break
        }
        'splineway;help;corners' {
            break
        }
        'splineway;help;paper' {
            break
        }
        'splineway;help;thesis' {
            break
        }
        'splineway;help;completions' {
            break
        }
        'splineway;help;help' {
            break
        }
    })

    $completions.Where{ $_.CompletionText -like "$wordToComplete*" } |
        Sort-Object -Property ListItemText
}
