//! Simulator.
use splineway_host::*;
use splineway_host::run::*;
struct Csv(std::io::BufWriter<std::fs::File>);
impl Observer for Csv { fn setpoint(&mut self,s:&Sample<'_>)->anyhow::Result<()> { use std::io::Write; writeln!(self.0,"{:.6},{:.15e},{:.15e},{:.15e}",s.time,s.position[0],s.position[1],s.position[2])?; Ok(()) } }
fn main()->anyhow::Result<()> {
    let a: Vec<String> = std::env::args().collect();
    let p = program::read(a[1].as_ref(), program::ReadOptions{feed:200.,segments:80})?;
    let mut m = machine::Machine::default();
    if let Some(h)=&p.header { m.apply(h); }
    let prec = if a[2]=="f32" {Precision::F32} else {Precision::F64};
    let track=Track::new(&p); let ax=m.axes_of(&p)?;
    let mut j=Judge::new(&track,&ax,m.cycle,m.tolerance);
    let t=std::time::Instant::now();
    let mut csv = a.get(3).map(|f| Csv(std::io::BufWriter::new(std::fs::File::create(f).unwrap())));
    let st = { let mut o: Vec<&mut dyn Observer> = vec![&mut j]; if let Some(c)=&mut csv { use std::io::Write; writeln!(c.0,"t,x,y,z")?; o.push(c); } run::run(&p,&m,prec,&mut o) };
    let v=j.verdict();
    println!("{} T {:.4} dev/tol {:.4} worst {:?} vpath {:.3} end {:.1e}", a[1].rsplit('/').next().unwrap(), v.time, v.deviation/m.tolerance, v.worst(), v.path_speed, v.end_error);
    match st { Ok(st)=>println!("   blocks {} {:?} least {} plan(ns) {:?} tick {:?} wall {:?}", st.blocks, st.counters, st.least_ahead, st.planning.summary(), st.ticks.summary(), t.elapsed()), Err(e)=>println!("   ERR {e:#}") }
    Ok(())
}
