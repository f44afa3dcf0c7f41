# Print an optspec for argparse to handle cmd's options that are independent of any subcommand.
function __fish_splineway_global_optspecs
    string join \n h/help V/version
end

function __fish_splineway_needs_command
    # Figure out if the current invocation already has a command.
    set -l cmd (commandline -opc)
    set -e cmd[1]
    argparse -s (__fish_splineway_global_optspecs) -- $cmd 2>/dev/null
    or return
    if set -q argv[1]
        # Also print the command, so this can be used to figure out what it is.
        echo $argv[1]
        return 1
    end
    return 0
end

function __fish_splineway_using_subcommand
    set -l cmd (__fish_splineway_needs_command)
    test -z "$cmd"
    and return 1
    contains -- $cmd[1] $argv
end

complete -c splineway -n "__fish_splineway_needs_command" -s h -l help -d 'Print help'
complete -c splineway -n "__fish_splineway_needs_command" -s V -l version -d 'Print version'
complete -c splineway -n "__fish_splineway_needs_command" -f -a "simulate" -d 'Runs a tool path through the motion core and judges every servo cycle'
complete -c splineway -n "__fish_splineway_needs_command" -f -a "check" -d 'Says what the core will do with a program: what was noticed while reading it, how long it takes, where the time goes, and the places that lose most of it'
complete -c splineway -n "__fish_splineway_needs_command" -f -a "stream" -d 'Sends a program to a controller and waits until it has been run'
complete -c splineway -n "__fish_splineway_needs_command" -f -a "controller" -d 'Runs the core as firmware does, on a pseudo-terminal or a TCP port, with the same protocols and no machine'
complete -c splineway -n "__fish_splineway_needs_command" -f -a "machine" -d 'Prints the machine that is used where none is described, as a description (TOML) to begin with: every key with its unit, and as comments what else a machine may have'
complete -c splineway -n "__fish_splineway_needs_command" -f -a "gcodes" -d 'Lists the G-codes that are read, as the reader\'s own tables have them'
complete -c splineway -n "__fish_splineway_needs_command" -f -a "formats" -d 'Lists the files that are read and written: programs, machines, operator\'s commands, setpoints, reports'
complete -c splineway -n "__fish_splineway_needs_command" -f -a "smooth" -d 'Smooths a B-spline tool path inside the tolerance tube around it, and reports curvature, length, feed and machining time before and after'
complete -c splineway -n "__fish_splineway_needs_command" -f -a "bench" -d 'Runs tool paths through the core in both number types, judges them, and prints times beside those of other speed laws, with memory and cost'
complete -c splineway -n "__fish_splineway_needs_command" -f -a "soak" -d 'Runs random programs on random machines while an operator presses anything at any moment, the interrupt comes in between any two accesses to shared state and the background is late; and holds every servo cycle, command and answer against the rules'
complete -c splineway -n "__fish_splineway_needs_command" -f -a "limit" -d 'Finds the least time of any motion inside the band of a tool path, shape and speed together, and says how near to it the planned motion is. It takes some seconds of work for every second of motion. What it finds can be reached, for the judge looks at it; that nothing is faster is not proven'
complete -c splineway -n "__fish_splineway_needs_command" -f -a "reshape" -d 'Plans a tool path, improves shape and speed of the planned motion together inside the band, window by window as a controller would, and judges what comes out. The controllers themselves do not do this yet'
complete -c splineway -n "__fish_splineway_needs_command" -f -a "corners" -d 'Compares corner transitions at equal deviation: smoothness, time, effort'
complete -c splineway -n "__fish_splineway_needs_command" -f -a "paper" -d 'Works out the routines of Guo, Yan, Wang 2023 as printed, runs the paths of the paper through the core in paper mode and in its own, and prints the figures side by side, with those of the paper\'s list of further work'
complete -c splineway -n "__fish_splineway_needs_command" -f -a "thesis" -d 'Smooths the cases of Naseath 2007 (equivalents) and the ripples of its section 3.12 as printed and in bounded sweeps, prints tables 4-1 to 4-7 beside the printed ones, and counts the figures that come out'
complete -c splineway -n "__fish_splineway_needs_command" -f -a "completions" -d 'Prints a script that completes this program\'s arguments in a shell'
complete -c splineway -n "__fish_splineway_needs_command" -f -a "help" -d 'Print this message or the help of the given subcommand(s)'
complete -c splineway -n "__fish_splineway_using_subcommand simulate" -l machine -d 'Machine description (TOML) [default: a small milling machine, which `splineway machine` prints]' -r -F
complete -c splineway -n "__fish_splineway_using_subcommand simulate" -l feed -d 'Feed of all moves but rapids, mm/s, in place of what the file says [default: the file\'s; 50 where it says nothing]' -r
complete -c splineway -n "__fish_splineway_using_subcommand simulate" -l dialect -d 'Whose G-code it is [default: told by comments and codes of the first 1000 lines where that is plain, else linuxcnc]' -r -f -a "linuxcnc\t'RS274/NGC, most milling machines: G4 P in seconds'
grbl\t'The same, with G0 in force at the beginning'
marlin\t'Printers: G4 P in milliseconds, E words, M codes with text'"
complete -c splineway -n "__fish_splineway_using_subcommand simulate" -l tolerance -d 'Greatest distance from the programmed path, mm, in place of the machine\'s, and of those that the program names (G64 P) [default: those]' -r
complete -c splineway -n "__fish_splineway_using_subcommand simulate" -l cycle -d 'Servo cycle, s [default: the machine\'s]' -r
complete -c splineway -n "__fish_splineway_using_subcommand simulate" -l lookahead -d 'Look-ahead depth, blocks: 16, 64 or 256 [default: the machine\'s]' -r
complete -c splineway -n "__fish_splineway_using_subcommand simulate" -l sweeps -d 'Smoothing sweeps over runs of short lines; 0 leaves them as they are laid [default: the machine\'s]' -r
complete -c splineway -n "__fish_splineway_using_subcommand simulate" -l scalar -d 'Number type of the core' -r -f -a "f32\t'As on a Cortex-M4F'
f64\t'As on a Cortex-M7'"
complete -c splineway -n "__fish_splineway_using_subcommand simulate" -l mode -d 'How corners are rounded [default: the machine\'s]' -r -f -a "band\t'Full tolerance band'
paper\t'As printed in Guo, Yan, Wang 2023'"
complete -c splineway -n "__fish_splineway_using_subcommand simulate" -l lambda -d 'Share of what is left of a line that stays straight between two of its corners, in paper mode, 0 to 0.99 [default: the machine\'s]' -r
complete -c splineway -n "__fish_splineway_using_subcommand simulate" -l segments -d 'Runs a NURBS curve as so many chords of equal parameter steps [default: as the curve itself]' -r
complete -c splineway -n "__fish_splineway_using_subcommand simulate" -l events -d 'Operator\'s commands: lines "time, action[, value]"; `splineway formats` lists the actions [default: none]' -r -F
complete -c splineway -n "__fish_splineway_using_subcommand simulate" -l setpoints -d 'Writes setpoints, one row per servo cycle (CSV) [default: not written]' -r -F
complete -c splineway -n "__fish_splineway_using_subcommand simulate" -l report -d 'Writes figures of the run (JSON) [default: not written]' -r -F
complete -c splineway -n "__fish_splineway_using_subcommand simulate" -l plot -d 'Writes a plot (.html, .svg or .png) [default: not written]' -r -F
complete -c splineway -n "__fish_splineway_using_subcommand simulate" -l lenient -d 'Leave out codes that cannot change where the tool goes, where they would be refused'
complete -c splineway -n "__fish_splineway_using_subcommand simulate" -l block-delete -d 'Leave out lines that begin with "/"'
complete -c splineway -n "__fish_splineway_using_subcommand simulate" -l reshape -d 'Improves shape and speed of the motion together, inside the band [default: the machine\'s]'
complete -c splineway -n "__fish_splineway_using_subcommand simulate" -l open -d 'Opens the plot; if --plot does not say where it goes, a page in the folder for temporary files'
complete -c splineway -n "__fish_splineway_using_subcommand simulate" -l compare -d 'Prints other speed laws on the same path beside this planner; the plot then shows their speeds along the way'
complete -c splineway -n "__fish_splineway_using_subcommand simulate" -l json -d 'Print the figures of the run as JSON'
complete -c splineway -n "__fish_splineway_using_subcommand simulate" -l quiet -d 'Print nothing but errors'
complete -c splineway -n "__fish_splineway_using_subcommand simulate" -s h -l help -d 'Print help (see more with \'--help\')'
complete -c splineway -n "__fish_splineway_using_subcommand check" -l machine -d 'Machine description (TOML) [default: a small milling machine, which `splineway machine` prints]' -r -F
complete -c splineway -n "__fish_splineway_using_subcommand check" -l feed -d 'Feed of all moves but rapids, mm/s, in place of what the file says [default: the file\'s; 50 where it says nothing]' -r
complete -c splineway -n "__fish_splineway_using_subcommand check" -l dialect -d 'Whose G-code it is [default: told by comments and codes of the first 1000 lines where that is plain, else linuxcnc]' -r -f -a "linuxcnc\t'RS274/NGC, most milling machines: G4 P in seconds'
grbl\t'The same, with G0 in force at the beginning'
marlin\t'Printers: G4 P in milliseconds, E words, M codes with text'"
complete -c splineway -n "__fish_splineway_using_subcommand check" -l tolerance -d 'Greatest distance from the programmed path, mm, in place of the machine\'s, and of those that the program names (G64 P) [default: those]' -r
complete -c splineway -n "__fish_splineway_using_subcommand check" -l places -d 'How many slow places are shown' -r
complete -c splineway -n "__fish_splineway_using_subcommand check" -l lenient -d 'Leave out codes that cannot change where the tool goes, where they would be refused'
complete -c splineway -n "__fish_splineway_using_subcommand check" -l block-delete -d 'Leave out lines that begin with "/"'
complete -c splineway -n "__fish_splineway_using_subcommand check" -l json -d 'Print JSON'
complete -c splineway -n "__fish_splineway_using_subcommand check" -l quiet -d 'Print nothing but warnings and errors'
complete -c splineway -n "__fish_splineway_using_subcommand check" -s h -l help -d 'Print help (see more with \'--help\')'
complete -c splineway -n "__fish_splineway_using_subcommand stream" -l port -d 'The serial port. It is locked: one sender at a time' -r -F
complete -c splineway -n "__fish_splineway_using_subcommand stream" -l baud -d 'Bits per second' -r
complete -c splineway -n "__fish_splineway_using_subcommand stream" -l watchdog -d 'Silence of this program after which the controller stops the machine, s, 0.1 to 60; 0: never' -r
complete -c splineway -n "__fish_splineway_using_subcommand stream" -l home -d 'How axes are homed at a line `$H` of the program, mm and mm/s: "X-40 Y-20 slow 4 reach 300 back 2 at 0 park 5" [default: none]' -r
complete -c splineway -n "__fish_splineway_using_subcommand stream" -l laser -d 'S and M3 to M5 are those of a laser with this greatest power [default: none]' -r
complete -c splineway -n "__fish_splineway_using_subcommand stream" -l machine -d 'Machine description (TOML) [default: a small milling machine, which `splineway machine` prints]' -r -F
complete -c splineway -n "__fish_splineway_using_subcommand stream" -l feed -d 'Feed of all moves but rapids, mm/s, in place of what the file says [default: the file\'s; 50 where it says nothing]' -r
complete -c splineway -n "__fish_splineway_using_subcommand stream" -l dialect -d 'Whose G-code it is [default: told by comments and codes of the first 1000 lines where that is plain, else linuxcnc]' -r -f -a "linuxcnc\t'RS274/NGC, most milling machines: G4 P in seconds'
grbl\t'The same, with G0 in force at the beginning'
marlin\t'Printers: G4 P in milliseconds, E words, M codes with text'"
complete -c splineway -n "__fish_splineway_using_subcommand stream" -l approach -d 'Move straight to the first point of a path that does not begin where the machine stands'
complete -c splineway -n "__fish_splineway_using_subcommand stream" -l abort -d 'Abort what a program before has left whose sender is gone'
complete -c splineway -n "__fish_splineway_using_subcommand stream" -l outputs -d 'Switch outputs in time with the path by M62 to M68; without it M62 to M65 are events'
complete -c splineway -n "__fish_splineway_using_subcommand stream" -l json -d 'Print what came of it as JSON'
complete -c splineway -n "__fish_splineway_using_subcommand stream" -l quiet -d 'Print nothing but errors'
complete -c splineway -n "__fish_splineway_using_subcommand stream" -l lenient -d 'Leave out codes that cannot change where the tool goes, where they would be refused'
complete -c splineway -n "__fish_splineway_using_subcommand stream" -l block-delete -d 'Leave out lines that begin with "/"'
complete -c splineway -n "__fish_splineway_using_subcommand stream" -s h -l help -d 'Print help (see more with \'--help\')'
complete -c splineway -n "__fish_splineway_using_subcommand controller" -l axes -d 'Axes: 3, 6 or 9' -r
complete -c splineway -n "__fish_splineway_using_subcommand controller" -l protocol -d 'What it speaks' -r -f -a "wire\t'That of `splineway stream`'
grbl\t'That of grbl 1.1, for senders that people have'"
complete -c splineway -n "__fish_splineway_using_subcommand controller" -l tcp -d 'Listen on this TCP port of this computer; 0 takes a free one [default: a pseudo-terminal]' -r
complete -c splineway -n "__fish_splineway_using_subcommand controller" -l settings -d 'Keep the settings of grbl in this file [default: in memory]' -r -F
complete -c splineway -n "__fish_splineway_using_subcommand controller" -l machine -d 'Machine description (TOML) [default: a small milling machine, which `splineway machine` prints]' -r -F
complete -c splineway -n "__fish_splineway_using_subcommand controller" -l switch -d 'A home switch, closed beyond a place, as "X>5" (mm, the machine being switched on at 0); more than those of the machine\'s file [default: none]' -r
complete -c splineway -n "__fish_splineway_using_subcommand controller" -l surface -d 'A surface that the probe meets there, as "Z<-20" [default: none]' -r
complete -c splineway -n "__fish_splineway_using_subcommand controller" -l speed -d 'How many times faster than the clock it runs' -r
complete -c splineway -n "__fish_splineway_using_subcommand controller" -l faults -d 'Share of the bytes that are lost, garbled or doubled, in either direction' -r
complete -c splineway -n "__fish_splineway_using_subcommand controller" -l once -d 'End after the first program'
complete -c splineway -n "__fish_splineway_using_subcommand controller" -s h -l help -d 'Print help (see more with \'--help\')'
complete -c splineway -n "__fish_splineway_using_subcommand machine" -s h -l help -d 'Print help'
complete -c splineway -n "__fish_splineway_using_subcommand gcodes" -l dialect -d 'Whose G-code' -r -f -a "linuxcnc\t'RS274/NGC, most milling machines: G4 P in seconds'
grbl\t'The same, with G0 in force at the beginning'
marlin\t'Printers: G4 P in milliseconds, E words, M codes with text'"
complete -c splineway -n "__fish_splineway_using_subcommand gcodes" -l all -d 'Also list what is refused by name, and what is left out'
complete -c splineway -n "__fish_splineway_using_subcommand gcodes" -l json -d 'Print JSON'
complete -c splineway -n "__fish_splineway_using_subcommand gcodes" -s h -l help -d 'Print help (see more with \'--help\')'
complete -c splineway -n "__fish_splineway_using_subcommand formats" -s h -l help -d 'Print help'
complete -c splineway -n "__fish_splineway_using_subcommand smooth" -l tolerance -d 'Radius of the tube, mm [default: the file\'s]' -r
complete -c splineway -n "__fish_splineway_using_subcommand smooth" -l precision -d 'Places per knot interval at which the thesis\'s method takes distances [default: the file\'s, or 5]' -r
complete -c splineway -n "__fish_splineway_using_subcommand smooth" -l accuracy -d 'Share of the radius within which the thesis\'s method ends [default: the file\'s, or 0.01]' -r
complete -c splineway -n "__fish_splineway_using_subcommand smooth" -l iterations -d 'Most iterations of the thesis\'s method, or sweeps per pass of the bounded one [default: 1000 iterations, 16 sweeps]' -r
complete -c splineway -n "__fish_splineway_using_subcommand smooth" -l method -d 'How to smooth' -r -f -a "thesis\t'Chapter 3 of Naseath 2007, as printed'
bounded\t'A set number of sweeps, inside the tube by a bound'"
complete -c splineway -n "__fish_splineway_using_subcommand smooth" -l feed -d 'Feed of the motion along it, mm/s, in place of what the file says [default: the file\'s; 400 where it says nothing]' -r
complete -c splineway -n "__fish_splineway_using_subcommand smooth" -l acceleration -d 'Its acceleration, mm/s2' -r
complete -c splineway -n "__fish_splineway_using_subcommand smooth" -l jerk -d 'Its jerk, mm/s3' -r
complete -c splineway -n "__fish_splineway_using_subcommand smooth" -l reading -d 'How section 4.5 of the thesis is read' -r -f -a "free\t'Greatest speeds lie anywhere between the least ones, and what an S-curve does not need is run at them'
middle\t'Word by word: extremes stay where they are, S-curves fill the distances; a plateau is one extreme'
edges\t'The same; a plateau is two'"
complete -c splineway -n "__fish_splineway_using_subcommand smooth" -l out -d 'Writes the smoothed spline (.json, .toml or .txt) [default: not written]' -r -F
complete -c splineway -n "__fish_splineway_using_subcommand smooth" -l report -d 'Writes figures and profiles (JSON) [default: not written]' -r -F
complete -c splineway -n "__fish_splineway_using_subcommand smooth" -l plot -d 'Writes a plot (.html, .svg or .png) [default: not written]' -r -F
complete -c splineway -n "__fish_splineway_using_subcommand smooth" -l closed -d 'The spline is closed: the knots are its intervals'
complete -c splineway -n "__fish_splineway_using_subcommand smooth" -l json -d 'Print the figures, without the profiles, as JSON'
complete -c splineway -n "__fish_splineway_using_subcommand smooth" -s h -l help -d 'Print help (see more with \'--help\')'
complete -c splineway -n "__fish_splineway_using_subcommand bench" -l json -d 'Print JSON'
complete -c splineway -n "__fish_splineway_using_subcommand bench" -s h -l help -d 'Print help'
complete -c splineway -n "__fish_splineway_using_subcommand soak" -l cases -d 'Cases to be run' -r
complete -c splineway -n "__fish_splineway_using_subcommand soak" -l seed -d 'Number of the first case; the same numbers give the same cases' -r
complete -c splineway -n "__fish_splineway_using_subcommand soak" -l threads -d 'Threads [default: as many as the machine has cores]' -r
complete -c splineway -n "__fish_splineway_using_subcommand soak" -l case -d 'Runs this case alone, and tells what happens in it [default: all of them]' -r
complete -c splineway -n "__fish_splineway_using_subcommand soak" -l plant -d 'Puts a bug between the core and the rest, to see whether it is found (0: the first of the list) [default: none]' -r
complete -c splineway -n "__fish_splineway_using_subcommand soak" -l shrink -d 'Shows the least case that breaks the same rule'
complete -c splineway -n "__fish_splineway_using_subcommand soak" -l json -d 'Print JSON'
complete -c splineway -n "__fish_splineway_using_subcommand soak" -l quiet -d 'Print nothing but what was broken'
complete -c splineway -n "__fish_splineway_using_subcommand soak" -s h -l help -d 'Print help'
complete -c splineway -n "__fish_splineway_using_subcommand limit" -l machine -d 'Machine description (TOML) [default: a small milling machine, which `splineway machine` prints]' -r -F
complete -c splineway -n "__fish_splineway_using_subcommand limit" -l feed -d 'Feed of all moves but rapids, mm/s, in place of what the file says [default: the file\'s; 50 where it says nothing]' -r
complete -c splineway -n "__fish_splineway_using_subcommand limit" -l dialect -d 'Whose G-code it is [default: told by comments and codes of the first 1000 lines where that is plain, else linuxcnc]' -r -f -a "linuxcnc\t'RS274/NGC, most milling machines: G4 P in seconds'
grbl\t'The same, with G0 in force at the beginning'
marlin\t'Printers: G4 P in milliseconds, E words, M codes with text'"
complete -c splineway -n "__fish_splineway_using_subcommand limit" -l tolerance -d 'Greatest distance from the programmed path, mm, in place of the machine\'s, and of those that the program names (G64 P) [default: those]' -r
complete -c splineway -n "__fish_splineway_using_subcommand limit" -l step -d 'Time between the knots of the motion, ms' -r
complete -c splineway -n "__fish_splineway_using_subcommand limit" -l rounds -d 'Most rounds' -r
complete -c splineway -n "__fish_splineway_using_subcommand limit" -l longest -d 'Longest motion that is looked at, s' -r
complete -c splineway -n "__fish_splineway_using_subcommand limit" -l setpoints -d 'Writes the setpoints of the motion found (CSV; one file only) [default: not written]' -r -F
complete -c splineway -n "__fish_splineway_using_subcommand limit" -l lenient -d 'Leave out codes that cannot change where the tool goes, where they would be refused'
complete -c splineway -n "__fish_splineway_using_subcommand limit" -l block-delete -d 'Leave out lines that begin with "/"'
complete -c splineway -n "__fish_splineway_using_subcommand limit" -l json -d 'Print JSON'
complete -c splineway -n "__fish_splineway_using_subcommand limit" -s h -l help -d 'Print help (see more with \'--help\')'
complete -c splineway -n "__fish_splineway_using_subcommand reshape" -l machine -d 'Machine description (TOML) [default: a small milling machine, which `splineway machine` prints]' -r -F
complete -c splineway -n "__fish_splineway_using_subcommand reshape" -l feed -d 'Feed of all moves but rapids, mm/s, in place of what the file says [default: the file\'s; 50 where it says nothing]' -r
complete -c splineway -n "__fish_splineway_using_subcommand reshape" -l dialect -d 'Whose G-code it is [default: told by comments and codes of the first 1000 lines where that is plain, else linuxcnc]' -r -f -a "linuxcnc\t'RS274/NGC, most milling machines: G4 P in seconds'
grbl\t'The same, with G0 in force at the beginning'
marlin\t'Printers: G4 P in milliseconds, E words, M codes with text'"
complete -c splineway -n "__fish_splineway_using_subcommand reshape" -l tolerance -d 'Greatest distance from the programmed path, mm, in place of the machine\'s, and of those that the program names (G64 P) [default: those]' -r
complete -c splineway -n "__fish_splineway_using_subcommand reshape" -l precision -d 'Scalar of the windows; the planned motion is of double precision' -r -f -a "f32\t'As on a Cortex-M4F'
f64\t'As on a Cortex-M7'"
complete -c splineway -n "__fish_splineway_using_subcommand reshape" -l setpoints -d 'Writes the setpoints of the improved motion (CSV; one file only) [default: not written]' -r -F
complete -c splineway -n "__fish_splineway_using_subcommand reshape" -l lenient -d 'Leave out codes that cannot change where the tool goes, where they would be refused'
complete -c splineway -n "__fish_splineway_using_subcommand reshape" -l block-delete -d 'Leave out lines that begin with "/"'
complete -c splineway -n "__fish_splineway_using_subcommand reshape" -l json -d 'Print JSON'
complete -c splineway -n "__fish_splineway_using_subcommand reshape" -s h -l help -d 'Print help (see more with \'--help\')'
complete -c splineway -n "__fish_splineway_using_subcommand corners" -l tolerance -d 'True deviation of every transition from the corner\'s legs, mm, up to 0.2' -r
complete -c splineway -n "__fish_splineway_using_subcommand corners" -l turns -d 'Turns, 15 to 155 degrees, with commas between: 30,60' -r
complete -c splineway -n "__fish_splineway_using_subcommand corners" -l machine -d 'Machine description (TOML), whose default axis counts [default: a small milling machine, which `splineway machine` prints]' -r -F
complete -c splineway -n "__fish_splineway_using_subcommand corners" -l json -d 'Print JSON'
complete -c splineway -n "__fish_splineway_using_subcommand corners" -s h -l help -d 'Print help'
complete -c splineway -n "__fish_splineway_using_subcommand paper" -l plots -d 'Writes pictures into this folder: the curvature profiles of figure 13b, and corners as in figure 12b (SVG) [default: not written]' -r -F
complete -c splineway -n "__fish_splineway_using_subcommand paper" -l json -d 'Print JSON'
complete -c splineway -n "__fish_splineway_using_subcommand paper" -s h -l help -d 'Print help'
complete -c splineway -n "__fish_splineway_using_subcommand thesis" -l plateau -d 'What a plateau of the speed is when section 4.5 is read word by word' -r -f -a "middle\t'One extreme, in its middle'
edges\t'Two, its edges'"
complete -c splineway -n "__fish_splineway_using_subcommand thesis" -l plots -d 'Writes figures 3-26, 3-27 and 4-8 to 4-31 into this folder [default: not written]' -r -F
complete -c splineway -n "__fish_splineway_using_subcommand thesis" -l json -d 'Print the figures of every case as JSON'
complete -c splineway -n "__fish_splineway_using_subcommand thesis" -s h -l help -d 'Print help (see more with \'--help\')'
complete -c splineway -n "__fish_splineway_using_subcommand completions" -s h -l help -d 'Print help'
complete -c splineway -n "__fish_splineway_using_subcommand help; and not __fish_seen_subcommand_from simulate check stream controller machine gcodes formats smooth bench soak limit reshape corners paper thesis completions help" -f -a "simulate" -d 'Runs a tool path through the motion core and judges every servo cycle'
complete -c splineway -n "__fish_splineway_using_subcommand help; and not __fish_seen_subcommand_from simulate check stream controller machine gcodes formats smooth bench soak limit reshape corners paper thesis completions help" -f -a "check" -d 'Says what the core will do with a program: what was noticed while reading it, how long it takes, where the time goes, and the places that lose most of it'
complete -c splineway -n "__fish_splineway_using_subcommand help; and not __fish_seen_subcommand_from simulate check stream controller machine gcodes formats smooth bench soak limit reshape corners paper thesis completions help" -f -a "stream" -d 'Sends a program to a controller and waits until it has been run'
complete -c splineway -n "__fish_splineway_using_subcommand help; and not __fish_seen_subcommand_from simulate check stream controller machine gcodes formats smooth bench soak limit reshape corners paper thesis completions help" -f -a "controller" -d 'Runs the core as firmware does, on a pseudo-terminal or a TCP port, with the same protocols and no machine'
complete -c splineway -n "__fish_splineway_using_subcommand help; and not __fish_seen_subcommand_from simulate check stream controller machine gcodes formats smooth bench soak limit reshape corners paper thesis completions help" -f -a "machine" -d 'Prints the machine that is used where none is described, as a description (TOML) to begin with: every key with its unit, and as comments what else a machine may have'
complete -c splineway -n "__fish_splineway_using_subcommand help; and not __fish_seen_subcommand_from simulate check stream controller machine gcodes formats smooth bench soak limit reshape corners paper thesis completions help" -f -a "gcodes" -d 'Lists the G-codes that are read, as the reader\'s own tables have them'
complete -c splineway -n "__fish_splineway_using_subcommand help; and not __fish_seen_subcommand_from simulate check stream controller machine gcodes formats smooth bench soak limit reshape corners paper thesis completions help" -f -a "formats" -d 'Lists the files that are read and written: programs, machines, operator\'s commands, setpoints, reports'
complete -c splineway -n "__fish_splineway_using_subcommand help; and not __fish_seen_subcommand_from simulate check stream controller machine gcodes formats smooth bench soak limit reshape corners paper thesis completions help" -f -a "smooth" -d 'Smooths a B-spline tool path inside the tolerance tube around it, and reports curvature, length, feed and machining time before and after'
complete -c splineway -n "__fish_splineway_using_subcommand help; and not __fish_seen_subcommand_from simulate check stream controller machine gcodes formats smooth bench soak limit reshape corners paper thesis completions help" -f -a "bench" -d 'Runs tool paths through the core in both number types, judges them, and prints times beside those of other speed laws, with memory and cost'
complete -c splineway -n "__fish_splineway_using_subcommand help; and not __fish_seen_subcommand_from simulate check stream controller machine gcodes formats smooth bench soak limit reshape corners paper thesis completions help" -f -a "soak" -d 'Runs random programs on random machines while an operator presses anything at any moment, the interrupt comes in between any two accesses to shared state and the background is late; and holds every servo cycle, command and answer against the rules'
complete -c splineway -n "__fish_splineway_using_subcommand help; and not __fish_seen_subcommand_from simulate check stream controller machine gcodes formats smooth bench soak limit reshape corners paper thesis completions help" -f -a "limit" -d 'Finds the least time of any motion inside the band of a tool path, shape and speed together, and says how near to it the planned motion is. It takes some seconds of work for every second of motion. What it finds can be reached, for the judge looks at it; that nothing is faster is not proven'
complete -c splineway -n "__fish_splineway_using_subcommand help; and not __fish_seen_subcommand_from simulate check stream controller machine gcodes formats smooth bench soak limit reshape corners paper thesis completions help" -f -a "reshape" -d 'Plans a tool path, improves shape and speed of the planned motion together inside the band, window by window as a controller would, and judges what comes out. The controllers themselves do not do this yet'
complete -c splineway -n "__fish_splineway_using_subcommand help; and not __fish_seen_subcommand_from simulate check stream controller machine gcodes formats smooth bench soak limit reshape corners paper thesis completions help" -f -a "corners" -d 'Compares corner transitions at equal deviation: smoothness, time, effort'
complete -c splineway -n "__fish_splineway_using_subcommand help; and not __fish_seen_subcommand_from simulate check stream controller machine gcodes formats smooth bench soak limit reshape corners paper thesis completions help" -f -a "paper" -d 'Works out the routines of Guo, Yan, Wang 2023 as printed, runs the paths of the paper through the core in paper mode and in its own, and prints the figures side by side, with those of the paper\'s list of further work'
complete -c splineway -n "__fish_splineway_using_subcommand help; and not __fish_seen_subcommand_from simulate check stream controller machine gcodes formats smooth bench soak limit reshape corners paper thesis completions help" -f -a "thesis" -d 'Smooths the cases of Naseath 2007 (equivalents) and the ripples of its section 3.12 as printed and in bounded sweeps, prints tables 4-1 to 4-7 beside the printed ones, and counts the figures that come out'
complete -c splineway -n "__fish_splineway_using_subcommand help; and not __fish_seen_subcommand_from simulate check stream controller machine gcodes formats smooth bench soak limit reshape corners paper thesis completions help" -f -a "completions" -d 'Prints a script that completes this program\'s arguments in a shell'
complete -c splineway -n "__fish_splineway_using_subcommand help; and not __fish_seen_subcommand_from simulate check stream controller machine gcodes formats smooth bench soak limit reshape corners paper thesis completions help" -f -a "help" -d 'Print this message or the help of the given subcommand(s)'
