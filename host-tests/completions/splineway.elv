
use builtin;
use str;

set edit:completion:arg-completer[splineway] = {|@words|
    fn spaces {|n|
        builtin:repeat $n ' ' | str:join ''
    }
    fn cand {|text desc|
        edit:complex-candidate $text &display=$text' '(spaces (- 14 (wcswidth $text)))$desc
    }
    var command = 'splineway'
    for word $words[1..-1] {
        if (str:has-prefix $word '-') {
            break
        }
        set command = $command';'$word
    }
    var completions = [
        &'splineway'= {
            cand -h 'Print help'
            cand --help 'Print help'
            cand -V 'Print version'
            cand --version 'Print version'
            cand simulate 'Runs a tool path through the motion core and judges every servo cycle'
            cand check 'Says what the core will do with a program: what was noticed while reading it, how long it takes, where the time goes, and the places that lose most of it'
            cand stream 'Sends a program to a controller and waits until it has been run'
            cand controller 'Runs the core as firmware does, on a pseudo-terminal or a TCP port, with the same protocols and no machine'
            cand machine 'Prints the machine that is used where none is described, as a description (TOML) to begin with: every key with its unit, and as comments what else a machine may have'
            cand gcodes 'Lists the G-codes that are read, as the reader''s own tables have them'
            cand formats 'Lists the files that are read and written: programs, machines, operator''s commands, setpoints, reports'
            cand smooth 'Smooths a B-spline tool path inside the tolerance tube around it, and reports curvature, length, feed and machining time before and after'
            cand bench 'Runs tool paths through the core in both number types, judges them, and prints times beside those of other speed laws, with memory and cost'
            cand soak 'Runs random programs on random machines while an operator presses anything at any moment, the interrupt comes in between any two accesses to shared state and the background is late; and holds every servo cycle, command and answer against the rules'
            cand limit 'Finds the least time of any motion inside the band of a tool path, shape and speed together, and says how near to it the planned motion is. It takes some seconds of work for every second of motion. What it finds can be reached, for the judge looks at it; that nothing is faster is not proven'
            cand reshape 'Plans a tool path, improves shape and speed of the planned motion together inside the band, window by window as a controller would, and judges what comes out. The controllers themselves do not do this yet'
            cand corners 'Compares corner transitions at equal deviation: smoothness, time, effort'
            cand paper 'Works out the routines of Guo, Yan, Wang 2023 as printed, runs the paths of the paper through the core in paper mode and in its own, and prints the figures side by side, with those of the paper''s list of further work'
            cand thesis 'Smooths the cases of Naseath 2007 (equivalents) and the ripples of its section 3.12 as printed and in bounded sweeps, prints tables 4-1 to 4-7 beside the printed ones, and counts the figures that come out'
            cand completions 'Prints a script that completes this program''s arguments in a shell'
            cand help 'Print this message or the help of the given subcommand(s)'
        }
        &'splineway;simulate'= {
            cand --machine 'Machine description (TOML) [default: a small milling machine, which `splineway machine` prints]'
            cand --feed 'Feed of all moves but rapids, mm/s, in place of what the file says [default: the file''s; 50 where it says nothing]'
            cand --dialect 'Whose G-code it is [default: told by comments and codes of the first 1000 lines where that is plain, else linuxcnc]'
            cand --tolerance 'Greatest distance from the programmed path, mm, in place of the machine''s, and of those that the program names (G64 P) [default: those]'
            cand --cycle 'Servo cycle, s [default: the machine''s]'
            cand --lookahead 'Look-ahead depth, blocks: 16, 64 or 256 [default: the machine''s]'
            cand --sweeps 'Smoothing sweeps over runs of short lines; 0 leaves them as they are laid [default: the machine''s]'
            cand --scalar 'Number type of the core'
            cand --mode 'How corners are rounded [default: the machine''s]'
            cand --lambda 'Share of what is left of a line that stays straight between two of its corners, in paper mode, 0 to 0.99 [default: the machine''s]'
            cand --segments 'Runs a NURBS curve as so many chords of equal parameter steps [default: as the curve itself]'
            cand --events 'Operator''s commands: lines "time, action[, value]"; `splineway formats` lists the actions [default: none]'
            cand --setpoints 'Writes setpoints, one row per servo cycle (CSV) [default: not written]'
            cand --report 'Writes figures of the run (JSON) [default: not written]'
            cand --plot 'Writes a plot (.html, .svg or .png) [default: not written]'
            cand --lenient 'Leave out codes that cannot change where the tool goes, where they would be refused'
            cand --block-delete 'Leave out lines that begin with "/"'
            cand --reshape 'Improves shape and speed of the motion together, inside the band [default: the machine''s]'
            cand --open 'Opens the plot; if --plot does not say where it goes, a page in the folder for temporary files'
            cand --compare 'Prints other speed laws on the same path beside this planner; the plot then shows their speeds along the way'
            cand --json 'Print the figures of the run as JSON'
            cand --quiet 'Print nothing but errors'
            cand -h 'Print help (see more with ''--help'')'
            cand --help 'Print help (see more with ''--help'')'
        }
        &'splineway;check'= {
            cand --machine 'Machine description (TOML) [default: a small milling machine, which `splineway machine` prints]'
            cand --feed 'Feed of all moves but rapids, mm/s, in place of what the file says [default: the file''s; 50 where it says nothing]'
            cand --dialect 'Whose G-code it is [default: told by comments and codes of the first 1000 lines where that is plain, else linuxcnc]'
            cand --tolerance 'Greatest distance from the programmed path, mm, in place of the machine''s, and of those that the program names (G64 P) [default: those]'
            cand --places 'How many slow places are shown'
            cand --lenient 'Leave out codes that cannot change where the tool goes, where they would be refused'
            cand --block-delete 'Leave out lines that begin with "/"'
            cand --json 'Print JSON'
            cand --quiet 'Print nothing but warnings and errors'
            cand -h 'Print help (see more with ''--help'')'
            cand --help 'Print help (see more with ''--help'')'
        }
        &'splineway;stream'= {
            cand --port 'The serial port. It is locked: one sender at a time'
            cand --baud 'Bits per second'
            cand --watchdog 'Silence of this program after which the controller stops the machine, s, 0.1 to 60; 0: never'
            cand --home 'How axes are homed at a line `$H` of the program, mm and mm/s: "X-40 Y-20 slow 4 reach 300 back 2 at 0 park 5" [default: none]'
            cand --laser 'S and M3 to M5 are those of a laser with this greatest power [default: none]'
            cand --machine 'Machine description (TOML) [default: a small milling machine, which `splineway machine` prints]'
            cand --feed 'Feed of all moves but rapids, mm/s, in place of what the file says [default: the file''s; 50 where it says nothing]'
            cand --dialect 'Whose G-code it is [default: told by comments and codes of the first 1000 lines where that is plain, else linuxcnc]'
            cand --approach 'Move straight to the first point of a path that does not begin where the machine stands'
            cand --abort 'Abort what a program before has left whose sender is gone'
            cand --outputs 'Switch outputs in time with the path by M62 to M68; without it M62 to M65 are events'
            cand --json 'Print what came of it as JSON'
            cand --quiet 'Print nothing but errors'
            cand --lenient 'Leave out codes that cannot change where the tool goes, where they would be refused'
            cand --block-delete 'Leave out lines that begin with "/"'
            cand -h 'Print help (see more with ''--help'')'
            cand --help 'Print help (see more with ''--help'')'
        }
        &'splineway;controller'= {
            cand --axes 'Axes: 3, 6 or 9'
            cand --protocol 'What it speaks'
            cand --tcp 'Listen on this TCP port of this computer; 0 takes a free one [default: a pseudo-terminal]'
            cand --settings 'Keep the settings of grbl in this file [default: in memory]'
            cand --machine 'Machine description (TOML) [default: a small milling machine, which `splineway machine` prints]'
            cand --switch 'A home switch, closed beyond a place, as "X>5" (mm, the machine being switched on at 0); more than those of the machine''s file [default: none]'
            cand --surface 'A surface that the probe meets there, as "Z<-20" [default: none]'
            cand --speed 'How many times faster than the clock it runs'
            cand --faults 'Share of the bytes that are lost, garbled or doubled, in either direction'
            cand --once 'End after the first program'
            cand -h 'Print help (see more with ''--help'')'
            cand --help 'Print help (see more with ''--help'')'
        }
        &'splineway;machine'= {
            cand -h 'Print help'
            cand --help 'Print help'
        }
        &'splineway;gcodes'= {
            cand --dialect 'Whose G-code'
            cand --all 'Also list what is refused by name, and what is left out'
            cand --json 'Print JSON'
            cand -h 'Print help (see more with ''--help'')'
            cand --help 'Print help (see more with ''--help'')'
        }
        &'splineway;formats'= {
            cand -h 'Print help'
            cand --help 'Print help'
        }
        &'splineway;smooth'= {
            cand --tolerance 'Radius of the tube, mm [default: the file''s]'
            cand --precision 'Places per knot interval at which the thesis''s method takes distances [default: the file''s, or 5]'
            cand --accuracy 'Share of the radius within which the thesis''s method ends [default: the file''s, or 0.01]'
            cand --iterations 'Most iterations of the thesis''s method, or sweeps per pass of the bounded one [default: 1000 iterations, 16 sweeps]'
            cand --method 'How to smooth'
            cand --feed 'Feed of the motion along it, mm/s, in place of what the file says [default: the file''s; 400 where it says nothing]'
            cand --acceleration 'Its acceleration, mm/s2'
            cand --jerk 'Its jerk, mm/s3'
            cand --reading 'How section 4.5 of the thesis is read'
            cand --out 'Writes the smoothed spline (.json, .toml or .txt) [default: not written]'
            cand --report 'Writes figures and profiles (JSON) [default: not written]'
            cand --plot 'Writes a plot (.html, .svg or .png) [default: not written]'
            cand --closed 'The spline is closed: the knots are its intervals'
            cand --json 'Print the figures, without the profiles, as JSON'
            cand -h 'Print help (see more with ''--help'')'
            cand --help 'Print help (see more with ''--help'')'
        }
        &'splineway;bench'= {
            cand --json 'Print JSON'
            cand -h 'Print help'
            cand --help 'Print help'
        }
        &'splineway;soak'= {
            cand --cases 'Cases to be run'
            cand --seed 'Number of the first case; the same numbers give the same cases'
            cand --threads 'Threads [default: as many as the machine has cores]'
            cand --case 'Runs this case alone, and tells what happens in it [default: all of them]'
            cand --plant 'Puts a bug between the core and the rest, to see whether it is found (0: the first of the list) [default: none]'
            cand --shrink 'Shows the least case that breaks the same rule'
            cand --json 'Print JSON'
            cand --quiet 'Print nothing but what was broken'
            cand -h 'Print help'
            cand --help 'Print help'
        }
        &'splineway;limit'= {
            cand --machine 'Machine description (TOML) [default: a small milling machine, which `splineway machine` prints]'
            cand --feed 'Feed of all moves but rapids, mm/s, in place of what the file says [default: the file''s; 50 where it says nothing]'
            cand --dialect 'Whose G-code it is [default: told by comments and codes of the first 1000 lines where that is plain, else linuxcnc]'
            cand --tolerance 'Greatest distance from the programmed path, mm, in place of the machine''s, and of those that the program names (G64 P) [default: those]'
            cand --step 'Time between the knots of the motion, ms'
            cand --rounds 'Most rounds'
            cand --longest 'Longest motion that is looked at, s'
            cand --setpoints 'Writes the setpoints of the motion found (CSV; one file only) [default: not written]'
            cand --lenient 'Leave out codes that cannot change where the tool goes, where they would be refused'
            cand --block-delete 'Leave out lines that begin with "/"'
            cand --json 'Print JSON'
            cand -h 'Print help (see more with ''--help'')'
            cand --help 'Print help (see more with ''--help'')'
        }
        &'splineway;reshape'= {
            cand --machine 'Machine description (TOML) [default: a small milling machine, which `splineway machine` prints]'
            cand --feed 'Feed of all moves but rapids, mm/s, in place of what the file says [default: the file''s; 50 where it says nothing]'
            cand --dialect 'Whose G-code it is [default: told by comments and codes of the first 1000 lines where that is plain, else linuxcnc]'
            cand --tolerance 'Greatest distance from the programmed path, mm, in place of the machine''s, and of those that the program names (G64 P) [default: those]'
            cand --precision 'Scalar of the windows; the planned motion is of double precision'
            cand --setpoints 'Writes the setpoints of the improved motion (CSV; one file only) [default: not written]'
            cand --lenient 'Leave out codes that cannot change where the tool goes, where they would be refused'
            cand --block-delete 'Leave out lines that begin with "/"'
            cand --json 'Print JSON'
            cand -h 'Print help (see more with ''--help'')'
            cand --help 'Print help (see more with ''--help'')'
        }
        &'splineway;corners'= {
            cand --tolerance 'True deviation of every transition from the corner''s legs, mm, up to 0.2'
            cand --turns 'Turns, 15 to 155 degrees, with commas between: 30,60'
            cand --machine 'Machine description (TOML), whose default axis counts [default: a small milling machine, which `splineway machine` prints]'
            cand --json 'Print JSON'
            cand -h 'Print help'
            cand --help 'Print help'
        }
        &'splineway;paper'= {
            cand --plots 'Writes pictures into this folder: the curvature profiles of figure 13b, and corners as in figure 12b (SVG) [default: not written]'
            cand --json 'Print JSON'
            cand -h 'Print help'
            cand --help 'Print help'
        }
        &'splineway;thesis'= {
            cand --plateau 'What a plateau of the speed is when section 4.5 is read word by word'
            cand --plots 'Writes figures 3-26, 3-27 and 4-8 to 4-31 into this folder [default: not written]'
            cand --json 'Print the figures of every case as JSON'
            cand -h 'Print help (see more with ''--help'')'
            cand --help 'Print help (see more with ''--help'')'
        }
        &'splineway;completions'= {
            cand -h 'Print help'
            cand --help 'Print help'
        }
        &'splineway;help'= {
            cand simulate 'Runs a tool path through the motion core and judges every servo cycle'
            cand check 'Says what the core will do with a program: what was noticed while reading it, how long it takes, where the time goes, and the places that lose most of it'
            cand stream 'Sends a program to a controller and waits until it has been run'
            cand controller 'Runs the core as firmware does, on a pseudo-terminal or a TCP port, with the same protocols and no machine'
            cand machine 'Prints the machine that is used where none is described, as a description (TOML) to begin with: every key with its unit, and as comments what else a machine may have'
            cand gcodes 'Lists the G-codes that are read, as the reader''s own tables have them'
            cand formats 'Lists the files that are read and written: programs, machines, operator''s commands, setpoints, reports'
            cand smooth 'Smooths a B-spline tool path inside the tolerance tube around it, and reports curvature, length, feed and machining time before and after'
            cand bench 'Runs tool paths through the core in both number types, judges them, and prints times beside those of other speed laws, with memory and cost'
            cand soak 'Runs random programs on random machines while an operator presses anything at any moment, the interrupt comes in between any two accesses to shared state and the background is late; and holds every servo cycle, command and answer against the rules'
            cand limit 'Finds the least time of any motion inside the band of a tool path, shape and speed together, and says how near to it the planned motion is. It takes some seconds of work for every second of motion. What it finds can be reached, for the judge looks at it; that nothing is faster is not proven'
            cand reshape 'Plans a tool path, improves shape and speed of the planned motion together inside the band, window by window as a controller would, and judges what comes out. The controllers themselves do not do this yet'
            cand corners 'Compares corner transitions at equal deviation: smoothness, time, effort'
            cand paper 'Works out the routines of Guo, Yan, Wang 2023 as printed, runs the paths of the paper through the core in paper mode and in its own, and prints the figures side by side, with those of the paper''s list of further work'
            cand thesis 'Smooths the cases of Naseath 2007 (equivalents) and the ripples of its section 3.12 as printed and in bounded sweeps, prints tables 4-1 to 4-7 beside the printed ones, and counts the figures that come out'
            cand completions 'Prints a script that completes this program''s arguments in a shell'
            cand help 'Print this message or the help of the given subcommand(s)'
        }
        &'splineway;help;simulate'= {
        }
        &'splineway;help;check'= {
        }
        &'splineway;help;stream'= {
        }
        &'splineway;help;controller'= {
        }
        &'splineway;help;machine'= {
        }
        &'splineway;help;gcodes'= {
        }
        &'splineway;help;formats'= {
        }
        &'splineway;help;smooth'= {
        }
        &'splineway;help;bench'= {
        }
        &'splineway;help;soak'= {
        }
        &'splineway;help;limit'= {
        }
        &'splineway;help;reshape'= {
        }
        &'splineway;help;corners'= {
        }
        &'splineway;help;paper'= {
        }
        &'splineway;help;thesis'= {
        }
        &'splineway;help;completions'= {
        }
        &'splineway;help;help'= {
        }
    ]
    $completions[$command]
}
