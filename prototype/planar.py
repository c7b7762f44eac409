import sys, json, time, traceback
sys.path.insert(0,'/tmp')
from conv import convert
from nonsmooth.proofs.many_states.many_certificate import _written
from nonsmooth.proofs.many_states.decision import decide_many
from nonsmooth.proofs.systems.system_certificate import NoCertificateError
from nonsmooth.symbolic.files.system_file import build_system
from tests.proofs.system_families import families
from checker.statements import refusal
count={}
tt=0
for i,k in enumerate(families()):
    check={"radius":1,"at":[0,0]}
    check.update(k.check)
    try:
        from pathlib import Path; system=build_system({"system":{"states":["x","y"],"rhs":list(k.rhs)},"check":dict(k.check)},"t",Path("t.toml"))
    except TypeError as e:
        print(e); break
    t0=time.time()
    try:
        r=decide_many(system); t1=time.time(); tt+=t1-t0
        v=str(r.verdict)
    except Exception as e:
        v='ERR '+repr(e)[:100]; print(i,k.name,k.truth,v,flush=True); continue
    try:
        new=convert(_written(r))
        b=refusal(new,len(json.dumps(new)))
        c='cert' if not b else 'REFUSED '+b
    except NoCertificateError as e:
        c='no: '+str(e)[-50:]
    except SystemExit as e: c=str(e)
    key=(v==k.truth, v, c=='cert'); count[key]=count.get(key,0)+1
    if v!=k.truth or c!='cert': print(i,k.name,'| truth',k.truth,'|',v,'|',c,round(t1-t0,2),flush=True)
print(count,round(tt,1))
